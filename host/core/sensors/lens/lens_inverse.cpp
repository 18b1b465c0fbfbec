// Inverse projection. Validity is decided by Lens::unproject, which projects the result again and rejects
// mismatches.
#include <algorithm>
#include <cmath>

#include "cl/shared/sensor_constants.h"
#include "host/core/sensors/lens.hpp"
#include "host/core/sensors/lens/lens_forward.hpp"

namespace simuli {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using lens_forward::Distorted;

constexpr int kRadialSteps = 100;  // of a bracketed Newton iteration: bisection alone needs 53
constexpr int kNewtonSteps = 100;
constexpr int kHalvings = 40;
// Rounding error relative to the image's radius.
constexpr double kRoundingOfOne = 4e-16;
constexpr double kNear = 1e-3;  // switches from the radial iteration to the quadratically convergent one in the plane

/// Solves f(t) = value for t in [0, end] with an increasing f that returns value and slope. Newton steps within
/// a bracket, bisection otherwise; `end` when f(end) is too small. Ends at a relative error of `tolerance` or
/// when t does not change.
template <class F>
double solve_increasing(F&& f, double value, double start, double end, double tolerance) {
  double low = 0.0, high = end;
  double t = std::clamp(start, low, high);
  for (int k = 0; k < kRadialSteps; ++k) {
    const auto [f_t, slope] = f(t);
    const double error = f_t - value;
    if (std::abs(error) <= tolerance * value) break;
    if (error <= 0.0) low = t;
    if (error >= 0.0) high = t;
    double next = t - error / slope;
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    if (next == t) break;
    t = next;
  }
  return t;
}

/// Undistorts coordinates: first along the direction, then in the plane with steps that are halved until they
/// improve, so that the iteration converges up to the fold.
Vector2d undistort(const double* k, const Vector2d& image, double radius2_max) {
  const double rho = image.norm();
  if (!(rho > 0.0)) return image;
  const Vector2d along = image / rho;
  const auto radial = [&](double r) {
    Distorted d;
    lens_forward::distort(k, r * along.x(), r * along.y(), &d);
    const double slope = along.x() * (d.u_x * along.x() + d.u_y * along.y()) +
                         along.y() * (d.v_x * along.x() + d.v_y * along.y());
    return std::pair(along.x() * d.u + along.y() * d.v, slope);
  };
  Vector2d m = solve_increasing(radial, rho, rho, std::sqrt(radius2_max), kNear) * along;
  Distorted d;
  lens_forward::distort(k, m.x(), m.y(), &d);
  Vector2d miss(d.u - image.x(), d.v - image.y());
  for (int step = 0; step < kNewtonSteps && !(miss.norm() <= kRoundingOfOne * rho); ++step) {
    const double determinant = d.u_x * d.v_y - d.u_y * d.v_x;
    const Vector2d full((d.v_y * miss.x() - d.u_y * miss.y()) / determinant,
                        (d.u_x * miss.y() - d.v_x * miss.x()) / determinant);
    bool closer = false;
    double share = 1.0;
    for (int half = 0; half < kHalvings && !closer; ++half, share *= 0.5) {
      const Vector2d next = m - share * full;
      Distorted at_next;
      lens_forward::distort(k, next.x(), next.y(), &at_next);
      const Vector2d next_miss(at_next.u - image.x(), at_next.v - image.y());
      closer = next_miss.squaredNorm() < miss.squaredNorm() && at_next.regular != 0 &&
               next.squaredNorm() <= radius2_max;
      if (!closer) continue;
      m = next;
      d = at_next;
      miss = next_miss;
    }
    if (!closer) break;
  }
  return m;
}

Vector3d at_angle(double angle, const Vector2d& image) {
  const double rho = image.norm();
  if (!(rho > 0.0)) return Vector3d::UnitZ();
  const double scale = std::sin(angle) / rho;
  return {image.x() * scale, image.y() * scale, std::cos(angle)};
}

Vector3d double_sphere_direction(const Vector2d& m, double xi, double alpha) {
  const double r2 = m.squaredNorm();
  const double z =
      (1.0 - alpha * alpha * r2) / (alpha * std::sqrt(1.0 - (2.0 * alpha - 1.0) * r2) + 1.0 - alpha);
  const double factor = (z * xi + std::sqrt(z * z + (1.0 - xi * xi) * r2)) / (z * z + r2);
  return {factor * m.x(), factor * m.y(), factor * z - xi};
}

}  // namespace

Vector3d Lens::inverse(const Vector2d& image) const {
  const auto& k = *constants_;
  const double* const a = k.polynomial;
  const Vector2d unlinear = [&]() -> Vector2d {
    if (kind_ != LensKind::kFtheta && kind_ != LensKind::kFthetaInverse) return image;
    const double c = k.linear[0], d = k.linear[1], e = k.linear[2];
    return Vector2d(image.x() - d * image.y(), c * image.y() - e * image.x()) / (c - d * e);
  }();
  const double rho = unlinear.norm();
  switch (kind_) {
    case LensKind::kPinhole:
      return {image.x(), image.y(), 1.0};
    case LensKind::kOpencvPinhole: {
      const Vector2d m = undistort(k.distortion, image, k.radius2_max);
      return {m.x(), m.y(), 1.0};
    }
    case LensKind::kOpencvFisheye: {
      const auto radius = [a](double t) {
        const double t2 = t * t;
        return std::pair(t * (1.0 + t2 * (a[0] + t2 * (a[1] + t2 * (a[2] + t2 * a[3])))),
                         1.0 + t2 * (3.0 * a[0] + t2 * (5.0 * a[1] + t2 * (7.0 * a[2] + t2 * 9.0 * a[3]))));
      };
      return at_angle(solve_increasing(radius, rho, rho, k.angle_max, kRoundingOfOne), unlinear);
    }
    case LensKind::kFtheta: {
      const auto radius = [a](double t) {
        return std::pair(lens_forward::polynomial5(a, t), lens_forward::polynomial5_slope(a, t));
      };
      return at_angle(solve_increasing(radius, rho, rho / a[0], k.angle_max, kRoundingOfOne), unlinear);
    }
    case LensKind::kFthetaInverse:
      return at_angle(lens_forward::polynomial5(a, rho), unlinear);
    case LensKind::kMei: {
      const Vector2d m = undistort(k.distortion, image, k.radius2_max);
      const double xi = k.xi, r2 = m.squaredNorm();
      const double factor = (xi + std::sqrt(1.0 + (1.0 - xi * xi) * r2)) / (r2 + 1.0);
      return {factor * m.x(), factor * m.y(), factor - xi};
    }
    case LensKind::kEquirectangular: {
      const double flat = std::cos(image.y());
      return {flat * std::sin(image.x()), std::sin(image.y()), flat * std::cos(image.x())};
    }
    case LensKind::kDoubleSphere:
      return double_sphere_direction(image, k.xi, k.alpha);
    case LensKind::kEucm: {
      const double alpha = k.alpha, beta = k.beta, r2 = image.squaredNorm();
      const double z = (1.0 - beta * alpha * alpha * r2) /
                       (alpha * std::sqrt(1.0 - (2.0 * alpha - 1.0) * beta * r2) + 1.0 - alpha);
      return {image.x(), image.y(), z};
    }
  }
  return Vector3d::Zero();
}

}  // namespace simuli

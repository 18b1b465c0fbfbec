// Domain in which a lens's map is injective.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "cl/shared/sensor_constants.h"
#include "host/core/base/angles.hpp"
#include "host/core/sensors/lens.hpp"
#include "host/core/sensors/lens/lens_forward.hpp"

namespace simuli {
namespace {

// Straight behind the camera one direction maps to a circle of the picture: the domain ends before.
constexpr double kLargestAngle_rad = kPi - 1e-5;
// The pinhole's limit, z >= 0.1 of the distance (PINHOLE_COS2_MIN of cl/math/camera.h).
const double kPinholeAngle_rad = std::acos(0.1);
constexpr int kSamples = 1024;    // along a search for a sign change
constexpr int kDirections = 128;  // around the axis
constexpr int kFewestSteps = 16;  // between a direction's fold and the farthest one
constexpr int kBisections = 60;   // to the last bit of an angle
constexpr double kDomainRounding = 1e-14;

/// First root of f in (0, end], or infinity; f > 0 up to sample `from`. sample(i) is f at end * i / kSamples. f
/// may dip below zero between samples: every local minimum of the samples is refined by golden section, except
/// where f is flat to rounding.
template <class F, class Sample>
double first_root(const F& f, const Sample& sample, double end, int from = 0) {
  const auto bisect = [&f](double above, double below) {
    for (int k = 0; k < kBisections; ++k) {
      const double middle = 0.5 * (above + below);
      (f(middle) > 0.0 ? above : below) = middle;
    }
    return above;
  };
  const double step = end / kSamples;
  if (from >= kSamples) return std::numeric_limits<double>::infinity();
  double before = sample(from), here = sample(from + 1);
  for (int i = from + 1; i <= kSamples; ++i) {
    const double t = i * step;
    if (!(here > 0.0)) return bisect(t - step, t);
    if (i == kSamples) break;
    const double after = sample(i + 1);
    const bool flat = std::max(before, after) - here <= kDomainRounding * here;
    if (here <= before && here <= after && !flat) {
      constexpr double kGolden = 0.3819660112501051;
      double low = t - step, high = t + step;
      for (int k = 0; k < kBisections; ++k) {
        const double a = low + kGolden * (high - low), b = high - kGolden * (high - low);
        if (!(f(a) > 0.0)) return bisect(t - step, a);
        if (!(f(b) > 0.0)) return bisect(t - step, b);
        if (f(a) < f(b)) {
          high = b;
        } else {
          low = a;
        }
      }
    }
    before = here;
    here = after;
  }
  return std::numeric_limits<double>::infinity();
}

template <class F>
double first_root(const F& f, double end) {
  return first_root(
      f, [&](int i) { return f(end * i / kSamples); }, end);
}

/// Determinant of the distortion's Jacobian at the radius, negative beyond a pole of the rational part; also
/// returns the distortion.
double orientation(const double* k,
                   double radius,
                   const Eigen::Vector2d& along,
                   lens_forward::Distorted* out) {
  lens_forward::distort(k, radius * along.x(), radius * along.y(), out);
  const double r2 = radius * radius;
  if (!(1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])) > 0.0)) return -1.0;
  return out->u_x * out->v_y - out->u_y * out->v_x;
}
double orientation(const double* k, double radius, const Eigen::Vector2d& along) {
  lens_forward::Distorted unused;
  return orientation(k, radius, along, &unused);
}

/// Last sample of the radii before any direction's fold: up to there the determinant of the radial part exceeds
/// the largest reduction by tangential and thin-prism terms. Ends where it rises again, because it may have
/// been lower between samples.
int samples_before_folds(const double* k, const std::array<double, kSamples + 1>& radius) {
  std::array<double, 12> radial{};
  std::copy_n(k, 12, radial.begin());
  radial[2] = radial[3] = 0.0;
  std::fill(radial.begin() + 8, radial.end(), 0.0);
  const double tangential = 6.0 * (std::abs(k[2]) + std::abs(k[3]));
  const double prism = std::abs(k[8]) + std::abs(k[10]), prism4 = std::abs(k[9]) + std::abs(k[11]);
  int sure = 0;
  double before = 1.0;
  bool falls = false;
  for (int i = 1; i <= kSamples; ++i) {
    const double r = radius[static_cast<std::size_t>(i)];
    lens_forward::Distorted d;
    const double determinant = orientation(radial.data(), r, Eigen::Vector2d::UnitX(), &d);
    // Entries of the radial Jacobian in any direction, and the largest contribution of the other terms.
    const double entry = std::abs(d.v_y) + std::abs(d.u_x - d.v_y);
    const double added = r * (tangential + 2.0 * prism + 4.0 * r * r * prism4);
    if (!(determinant > added * (4.0 * entry + 2.0 * added))) break;
    if (falls && determinant > before) return std::max(sure - 1, 0);
    falls = falls || determinant < before * (1.0 - kDomainRounding);
    before = determinant;
    sure = i;
  }
  return sure;
}

/// Largest squared radius before the fold for points with a positive determinant. radius_of: increasing radius
/// by a parameter from 0 to `end`.
template <class Radius>
double largest_radius2(const double* k, const Radius& radius_of, double end) {
  const bool symmetric =
      std::all_of(k + 8, k + 12, [](double s) { return s == 0.0; }) && k[2] == 0.0 && k[3] == 0.0;
  const int directions = symmetric ? 1 : kDirections;
  // Searching the fold dominates the cost of making a lens: directions share samples.
  std::array<double, kSamples + 1> radius{};
  for (int i = 0; i <= kSamples; ++i) radius[static_cast<std::size_t>(i)] = radius_of(end * i / kSamples);
  const int sure = symmetric ? 0 : samples_before_folds(k, radius);
  std::array<Eigen::Vector2d, kDirections> along;
  std::array<double, kDirections> fold{};
  double first = end, last = 0.0;
  for (int i = 0; i < directions; ++i) {
    const double direction = 2.0 * kPi * i / directions;
    const auto at = static_cast<std::size_t>(i);
    along[at] = {std::cos(direction), std::sin(direction)};
    const auto of_angle = [&](double t) { return orientation(k, radius_of(t), along[at]); };
    const auto of_sample = [&](int j) {
      return orientation(k, radius[static_cast<std::size_t>(j)], along[at]);
    };
    fold[at] = std::min(end, first_root(of_angle, of_sample, end, sure));
    first = std::min(first, fold[at]);
    last = std::max(last, fold[at]);
  }
  // Between its own fold and the farthest one every direction must stay reversed, or points there would be
  // accepted again. Other lenses are cut at the nearest fold.
  for (int i = 0; i < directions; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double own = fold[at];
    const int steps =
        own < last ? std::max(kFewestSteps, static_cast<int>(kSamples * (last - own) / end)) : 0;
    for (int j = 1; j <= steps; ++j) {
      const double t = own + (last - own) * j / steps;
      if (orientation(k, radius_of(t), along[at]) > 0.0) return radius_of(first) * radius_of(first);
    }
  }
  return radius_of(last) * radius_of(last);
}

}  // namespace

void Lens::find_domain(double max_angle_rad) {
  auto& k = *constants_;
  const double largest = std::min(max_angle_rad, kLargestAngle_rad);
  switch (kind_) {
    case LensKind::kPinhole:
    case LensKind::kEquirectangular:
      break;
    case LensKind::kOpencvPinhole: {
      const double end = std::min(largest, kPinholeAngle_rad);
      k.radius2_max = largest_radius2(
          k.distortion, [](double angle) { return std::tan(angle); }, end);
      break;
    }
    case LensKind::kOpencvFisheye: {
      const double* const c = k.polynomial;
      const auto slope = [c](double angle) {
        const double a2 = angle * angle;
        return 1.0 + a2 * (3.0 * c[0] + a2 * (5.0 * c[1] + a2 * (7.0 * c[2] + a2 * 9.0 * c[3])));
      };
      k.angle_max = std::min(largest, first_root(slope, largest));
      break;
    }
    case LensKind::kFtheta: {
      const auto slope = [&k](double angle) { return lens_forward::polynomial5_slope(k.polynomial, angle); };
      k.angle_max = std::min(largest, first_root(slope, largest));
      break;
    }
    case LensKind::kFthetaInverse: {
      const double* const b = k.polynomial;
      // Eight times the radius at which the linear coefficient alone reaches the largest angle: an upper bound
      // for real lenses.
      const double end = 8.0 * largest / b[0];
      const double fold =
          std::min(end, first_root([b](double r) { return lens_forward::polynomial5_slope(b, r); }, end));
      const double angle_at_fold = lens_forward::polynomial5(b, fold);
      const double angle = std::min(largest, angle_at_fold);
      k.angle_max = angle;
      k.radius_max = angle < angle_at_fold ? lens_forward::polynomial5_inverse(b, angle, fold) : fold;
      break;
    }
    case LensKind::kMei: {
      const double xi = k.xi;
      // The mirror's map ends where its ray is tangent (xi > 1) or parallel to the plane.
      const double mirror = std::acos(-(xi > 1.0 ? 1.0 / xi : xi));
      const double end = std::min(largest, mirror - 1e-5);
      k.cos_min = std::cos(end);
      k.radius2_max = largest_radius2(
          k.distortion, [xi](double angle) { return std::sin(angle) / (std::cos(angle) + xi); }, end);
      break;
    }
    case LensKind::kDoubleSphere: {
      const double xi = k.xi, alpha = k.alpha;
      const double w1 = alpha <= 0.5 ? alpha / (1.0 - alpha) : (1.0 - alpha) / alpha;
      const double w2 = (w1 + xi) / std::sqrt(2.0 * w1 * xi + xi * xi + 1.0);
      k.cos_min = std::max(std::cos(largest), -w2);
      break;
    }
    case LensKind::kEucm: {
      const double alpha = k.alpha, beta = k.beta;
      const double w = alpha <= 0.5 ? alpha / (1.0 - alpha) : (1.0 - alpha) / alpha;
      // z > -w d with d^2 = beta (x^2 + y^2) + z^2, as a cosine.
      const double cosine = -w * std::sqrt(beta / (1.0 - w * w + w * w * beta));
      k.cos_min = std::max(std::cos(largest), cosine);
      break;
    }
  }
}

}  // namespace simuli

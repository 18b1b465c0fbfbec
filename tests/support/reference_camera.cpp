// Implements the lenses of tests/support/reference.hpp, independently of cl/math/camera.h.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/core/base/error.hpp"
#include "tests/support/reference.hpp"

namespace simuli::reference {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// minimum z / |p| of a valid point of the pinhole: about 84 degrees off axis
constexpr double kMinAxisCosine = 0.1;

/// Kannala-Brandt with parameters k1..k4, max_angle_rad; the radius must increase up to that angle.
double fisheye_radius(const std::vector<double>& p, double angle) {
  return angle + p[0] * std::pow(angle, 3) + p[1] * std::pow(angle, 5) + p[2] * std::pow(angle, 7) +
         p[3] * std::pow(angle, 9);
}

/// sum of c a^i b^j, ordered by j, then by i.
double bivariate(const std::vector<double>& c, const Vector2d& at) {
  int degree = 0;
  while (static_cast<std::size_t>((degree + 1) * (degree + 2) / 2) < c.size()) ++degree;
  double sum = 0.0;
  std::size_t k = 0;
  for (int j = 0; j <= degree; ++j) {
    for (int i = 0; i <= degree - j; ++i) sum += c[k++] * std::pow(at.x(), i) * std::pow(at.y(), j);
  }
  return sum;
}

/// Maps a direction through the windshield, towards the lens or away from it, with its length kept.
/// Polynomials that are exact in the other direction are inverted by iteration, which converges because glass
/// bends little.
Vector3d through_glass(const Windshield& glass, const Vector3d& p, bool to_lens) {
  const Vector3d n = p.normalized();
  const Vector2d from(std::asin(n.x()), std::asin(n.y()));
  const bool is_forward = glass.reference == Windshield::Reference::kForward;
  const auto value = [&](const Vector2d& at) {
    return is_forward
               ? Vector2d(bivariate(glass.horizontal, at), bivariate(glass.vertical, at))
               : Vector2d(bivariate(glass.horizontal_inverse, at), bivariate(glass.vertical_inverse, at));
  };
  Vector2d to = from;
  if (is_forward == to_lens) {
    to = value(from);
  } else {
    for (int k = 0; k < 60; ++k) to -= value(to) - from;
  }
  const double x = std::sin(to.x()), y = std::sin(to.y());
  return p.norm() * Vector3d(x, y, std::sqrt(1.0 - x * x - y * y));
}

bool is_ideal(const Lens& lens) {
  const auto& p = lens.parameters();
  return lens.kind() == LensKind::kPinhole ||
         (lens.kind() == LensKind::kOpencvPinhole &&
          std::all_of(p.begin(), p.end() - 1, [](double value) { return value == 0.0; }));
}

[[noreturn]] void unknown_lens(const Camera& camera) {
  throw Error(ErrorKind::kInternal,
              std::string("the reference has no lens ") + to_string(camera.lens.kind()));
}

}  // namespace

bool camera_image(const Camera& camera, const Vector3d& p_camera, Vector2d& pixel) {
  const auto& parameters = camera.lens.parameters();
  const auto& glass = camera.lens.windshield();
  if (glass && !(p_camera.z() > 0.0)) return false;
  const Vector3d p = glass ? through_glass(*glass, p_camera, true) : p_camera;
  switch (is_ideal(camera.lens) ? LensKind::kPinhole : camera.lens.kind()) {
    case LensKind::kPinhole: {
      const bool valid = p.z() > kCameraNear_m && p.z() >= kMinAxisCosine * p.norm();
      if (!valid) return false;
      pixel = {camera.fx * p.x() / p.z() + camera.cx, camera.fy * p.y() / p.z() + camera.cy};
      return true;
    }
    case LensKind::kOpencvFisheye: {
      const double angle = std::atan2(std::hypot(p.x(), p.y()), p.z());
      if (!(angle <= parameters[4] && p.norm() > kCameraNear_m)) return false;
      const double direction = std::atan2(p.y(), p.x());
      const double radius = fisheye_radius(parameters, angle);
      pixel = {camera.fx * radius * std::cos(direction) + camera.cx,
               camera.fy * radius * std::sin(direction) + camera.cy};
      return true;
    }
    case LensKind::kEquirectangular: {
      if (!(p.norm() > kCameraNear_m)) return false;
      pixel = {camera.fx * std::atan2(p.x(), p.z()) + camera.cx,
               camera.fy * std::asin(p.y() / p.norm()) + camera.cy};
      return true;
    }
    default:
      unknown_lens(camera);
  }
}

namespace {

/// Returns the direction behind the windshield, if there is one.
Vector3d lens_direction(const Camera& camera, const Vector2d& pixel) {
  const Vector2d image((pixel.x() - camera.cx) / camera.fx, (pixel.y() - camera.cy) / camera.fy);
  switch (is_ideal(camera.lens) ? LensKind::kPinhole : camera.lens.kind()) {
    case LensKind::kPinhole:
      return {image.x(), image.y(), 1.0};
    case LensKind::kOpencvFisheye: {
      const auto& parameters = camera.lens.parameters();
      double low = 0.0, high = parameters[4];
      if (fisheye_radius(parameters, high) < image.norm()) return Vector3d::Zero();
      for (int k = 0; k < 60; ++k) {
        const double middle = 0.5 * (low + high);
        (fisheye_radius(parameters, middle) < image.norm() ? low : high) = middle;
      }
      const double direction = std::atan2(image.y(), image.x());
      return {std::sin(low) * std::cos(direction), std::sin(low) * std::sin(direction), std::cos(low)};
    }
    case LensKind::kEquirectangular: {
      if (std::abs(image.y()) > std::numbers::pi / 2.0) return Vector3d::Zero();
      return {std::cos(image.y()) * std::sin(image.x()),
              std::sin(image.y()),
              std::cos(image.y()) * std::cos(image.x())};
    }
    default:
      unknown_lens(camera);
  }
}

}  // namespace

Vector3d camera_direction(const Camera& camera, const Vector2d& pixel) {
  const Vector3d behind = lens_direction(camera, pixel);
  if (!camera.lens.windshield() || behind.isZero(0.0)) return behind;
  return through_glass(*camera.lens.windshield(), behind, false);
}

double px2_per_sr(const Camera& camera) {
  const double bare = camera.fx * camera.fy;
  if (!camera.lens.windshield()) return bare;
  constexpr double kStep = 1e-4;
  const auto bent = [&](double x, double y) -> Vector3d {
    return through_glass(*camera.lens.windshield(), Vector3d(x, y, 1.0).normalized(), true);
  };
  const Vector3d along_x = bent(kStep, 0.0) - bent(-kStep, 0.0),
                 along_y = bent(0.0, kStep) - bent(0.0, -kStep);
  return bare * along_x.cross(along_y).norm() / (4.0 * kStep * kStep);
}

}  // namespace simuli::reference

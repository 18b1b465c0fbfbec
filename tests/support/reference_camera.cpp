// The lenses of tests/support/reference.hpp, written down independently of cl/math/camera.h.
#include <cmath>
#include <numbers>

#include "host/base/error.hpp"
#include "tests/support/reference.hpp"

namespace simuli::reference {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kCameraNear_m = 0.01;
constexpr double kMinAxisCosine = 0.1;  // z / |p| of a valid point of the pinhole: about 84 degrees off axis

/// Kannala-Brandt with parameters k1..k4, max_angle_rad; its radius has to grow up to that angle.
double fisheye_radius(const std::vector<double>& p, double angle) {
  return angle + p[0] * std::pow(angle, 3) + p[1] * std::pow(angle, 5) + p[2] * std::pow(angle, 7) +
         p[3] * std::pow(angle, 9);
}

[[noreturn]] void unknown_lens(const Camera& camera) {
  throw Error(ErrorKind::kInternal,
              std::string("the reference has no lens ") + to_string(camera.lens.kind()));
}

}  // namespace

bool camera_image(const Camera& camera, const Vector3d& p, Vector2d& pixel) {
  const auto& parameters = camera.lens.parameters();
  switch (camera.lens.kind()) {
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

Vector3d camera_direction(const Camera& camera, const Vector2d& pixel) {
  const Vector2d image((pixel.x() - camera.cx) / camera.fx, (pixel.y() - camera.cy) / camera.fy);
  switch (camera.lens.kind()) {
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

}  // namespace simuli::reference

// Lenses behind a windshield: the domain in which the map is injective, and the inverse.
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

#include "cl/shared/sensor_constants.h"
#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "host/core/sensors/lens.hpp"
#include "host/core/sensors/lens/lens_forward.hpp"

namespace simuli {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kLargestTerm = 1e3;        // limit of coefficients; real ones are below 2
constexpr double kSmallestCone_rad = 0.01;  // smallest accepted cone
constexpr double kBendStep_rad = 0.25 * kPi / 180.0;
constexpr double kReach_rad = 89.0 * kPi / 180.0;  // asin() is only defined for the front
constexpr int kBendDirections = 72;
constexpr int kUnbendSteps = 50;
constexpr double kUnbendMiss_rad = 1e-12;

/// Extends the coefficients of a polynomial of any degree to degree 5.
void fill(const std::vector<double>& from, double* to, const std::string& file, const char* name) {
  constexpr std::array<std::size_t, 6> kCounts{1, 3, 6, 10, 15, 21};
  const auto found = std::find(kCounts.begin(), kCounts.end(), from.size());
  if (found == kCounts.end()) {
    throw_input_error(file,
                      fmt::format("windshield.{}", name),
                      fmt::format("{} coefficients", from.size()),
                      "1, 3, 6, 10, 15 or 21");
  }
  const auto degree = static_cast<std::size_t>(found - kCounts.begin());
  std::fill_n(to, SIM_BEND_TERMS, 0.0);
  std::size_t at = 0;
  for (std::size_t j = 0; j <= degree; ++j) {
    for (std::size_t i = 0; i <= degree - j; ++i) {
      const double value = from[at++];
      if (!(std::abs(value) <= kLargestTerm)) {
        throw_input_error(
            file, fmt::format("windshield.{}", name), fmt::format("{}", value), "finite, at most 1000");
      }
      to[j * (13 - j) / 2 + i] = value;
    }
  }
}

Vector2d angles_of(const Vector3d& unit) {
  return {std::atan2(unit.x(), std::hypot(unit.y(), unit.z())),
          std::atan2(unit.y(), std::hypot(unit.x(), unit.z()))};
}

Vector3d direction_of(const Vector2d& angles) {
  const double x = std::sin(angles.x()), y = std::sin(angles.y());
  const double left = 1.0 - x * x - y * y;
  return left > 0.0 ? Vector3d(x, y, std::sqrt(left)) : Vector3d::Zero();
}

Vector2d value_of(const double* horizontal, const double* vertical, const Vector2d& at) {
  Vector2d value, unused;
  lens_forward::bend_polynomial(horizontal, at.x(), at.y(), &value.x(), &unused.x(), &unused.y());
  lens_forward::bend_polynomial(vertical, at.x(), at.y(), &value.y(), &unused.x(), &unused.y());
  return value;
}

}  // namespace

Lens Lens::behind(const Windshield& glass, const std::string& file) const {
  if (kind_ == LensKind::kEquirectangular) {
    throw_input_error(
        file, "windshield", "one before an equirectangular lens", "none: the lens covers all directions");
  }
  Lens out = kind_ == LensKind::kPinhole
                 ? Lens(LensKind::kOpencvPinhole, {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, kPi}, file)
                 : *this;
  out.constants_ = std::make_shared<shared::LensConstants<double>>(*out.constants_);
  out.windshield_ = glass;
  auto& c = *out.constants_;
  const bool is_backward = glass.reference == Windshield::Reference::kBackward;
  c.bend = is_backward ? SIM_BEND_BACKWARD : SIM_BEND_FORWARD;
  const auto forth_h = is_backward ? c.bend_back_horizontal : c.bend_horizontal;
  const auto forth_v = is_backward ? c.bend_back_vertical : c.bend_vertical;
  const auto back_h = is_backward ? c.bend_horizontal : c.bend_back_horizontal;
  const auto back_v = is_backward ? c.bend_vertical : c.bend_back_vertical;
  fill(glass.horizontal, forth_h, file, "horizontal");
  fill(glass.vertical, forth_v, file, "vertical");
  fill(glass.horizontal_inverse, back_h, file, "horizontal_inverse");
  fill(glass.vertical_inverse, back_v, file, "vertical_inverse");
  out.find_bent_domain(file);
  return out;
}

void Lens::find_bent_domain(const std::string& file) {
  auto& c = *constants_;
  c.bend_cos_min = std::cos(kReach_rad);
  const bool is_backward = c.bend == SIM_BEND_BACKWARD;
  /// Whether a ray passes, preserves orientation, and is inverted correctly.
  const auto is_regular = [&](const Vector3d& direction) {
    Vector3d bent;
    if (!bend(direction, bent)) return false;
    Vector2d from = angles_of(direction), to = angles_of(bent);
    const Vector2d again = is_backward ? value_of(c.bend_horizontal, c.bend_vertical, to) : from;
    if (!((again - from).norm() <= 1e-9)) return false;
    Vector2d& at = is_backward ? to : from;
    const Vector2d target = is_backward ? from : to;
    return lens_forward::bend_step(
               c.bend_horizontal, c.bend_vertical, target.x(), target.y(), &at.x(), &at.y()) != 0;
  };
  double cone = 0.0;
  for (double angle = 0.0; angle < kReach_rad; angle += kBendStep_rad) {
    bool is_whole = true;
    for (int k = 0; k < kBendDirections && is_whole; ++k) {
      const double phi = 2.0 * kPi * k / kBendDirections;
      is_whole =
          is_regular({std::sin(angle) * std::cos(phi), std::sin(angle) * std::sin(phi), std::cos(angle)});
    }
    if (!is_whole) break;
    cone = angle;
  }
  if (!(cone >= kSmallestCone_rad)) {
    throw_input_error(
        file, "windshield", "polynomials that are not one to one about the axis", "those that are");
  }
  c.bend_cos_min = std::cos(cone);
}

Vector3d Lens::unbend(const Vector3d& bent) const {
  if (!windshield_) return bent;
  const auto& c = *constants_;
  const Vector2d from = angles_of(bent);
  if (c.bend == SIM_BEND_BACKWARD) return direction_of(value_of(c.bend_horizontal, c.bend_vertical, from));
  Vector2d at = value_of(c.bend_back_horizontal, c.bend_back_vertical, from);
  for (int k = 0; k < kUnbendSteps; ++k) {
    const Vector2d before = at;
    (void)lens_forward::bend_step(c.bend_horizontal, c.bend_vertical, from.x(), from.y(), &at.x(), &at.y());
    if (!((at - before).norm() > kUnbendMiss_rad)) break;
  }
  return direction_of(at);
}

}  // namespace simuli

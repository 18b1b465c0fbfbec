// Additional shapes of the detailed street.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/street/detail.hpp"

namespace simuli::bench {

using Eigen::Vector3d;

bool meet_rod(const StreetSolid& solid,
              const Vector3d& origin,
              const Vector3d& direction,
              const Vector3d& /*inverse*/,
              StreetCrossing& nearest) {
  const double length2 = solid.axis.squaredNorm(), radius2 = solid.radius * solid.radius;
  const Vector3d arm = origin - solid.centre;
  bool met = false;
  const auto take = [&](double range, double place) {
    if (!(range > kNearestHit_m && range < nearest.range)) return;
    nearest.range = range;
    nearest.normal = (arm + range * direction - place * solid.axis) / solid.radius;
    met = true;
  };
  const double along = direction.dot(solid.axis) / length2, at = arm.dot(solid.axis) / length2;
  const Vector3d across = direction - along * solid.axis, off = arm - at * solid.axis;
  const double speed2 = across.squaredNorm();
  if (speed2 > 0.0) {
    const double closest = -off.dot(across) / speed2;
    const double discriminant = radius2 - (off + closest * across).squaredNorm();
    if (!(discriminant > 0.0)) return false;  // the ends are flat
    const double range = closest - std::sqrt(discriminant / speed2), place = at + range * along;
    if (place >= 0.0 && place <= 1.0) take(range, place);
  }
  for (const double end : {0.0, 1.0}) {
    const Vector3d from_end = arm - end * solid.axis;
    const double half_b = from_end.dot(direction);
    const double discriminant = radius2 - (from_end - half_b * direction).squaredNorm();
    if (discriminant > 0.0) take(-half_b - std::sqrt(discriminant), end);
  }
  return met;
}

bool meet_cut(const StreetSolid& solid,
              const Vector3d& origin,
              const Vector3d& direction,
              const Vector3d& inverse,
              StreetCrossing& nearest) {
  const double above_m = solid.axis.dot(origin) - solid.radius, climb = solid.axis.dot(direction);
  if (climb >= 0.0 && above_m >= 0.0) return false;
  StreetCrossing whole{nearest.range, Vector3d::Zero()};
  const bool meets_box = meet_box(solid, origin, direction, inverse, whole);
  const double plane = climb == 0.0 ? 0.0 : -above_m / climb;
  if (above_m < 0.0) {  // a ray from inside the removed part enters at the plane, if at all
    if (!meets_box || (climb > 0.0 && whole.range >= plane)) return false;
    nearest = whole;
    return true;
  }
  if (meets_box && whole.range >= plane) {
    nearest = whole;
    return true;
  }
  const Vector3d point = origin + plane * direction;
  if (!(plane > kNearestHit_m && plane < nearest.range)) return false;
  if ((point.array() < solid.low.array()).any() || (point.array() > solid.high.array()).any()) return false;
  nearest = {plane, solid.axis};
  return true;
}

bool meet_plate(const StreetSolid& solid,
                const Vector3d& origin,
                const Vector3d& direction,
                const Vector3d& /*inverse*/,
                StreetCrossing& nearest) {
  if (direction.x() == 0.0) return false;
  const double range = (solid.centre.x() - origin.x()) / direction.x();
  if (!(range > kNearestHit_m && range < nearest.range)) return false;
  const Vector3d point = origin + range * direction - solid.centre;
  const int sides = static_cast<int>(solid.axis.x());
  double out_m = sides == 0 ? std::hypot(point.y(), point.z()) : 0.0;
  for (int k = 0; k < sides; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / sides;
    out_m = std::max(out_m, std::sin(angle) * point.y() - std::cos(angle) * point.z());
  }
  if (out_m > solid.radius) return false;
  nearest = {range, (direction.x() > 0.0 ? -1.0 : 1.0) * Vector3d::UnitX()};
  return true;
}

}  // namespace simuli::bench

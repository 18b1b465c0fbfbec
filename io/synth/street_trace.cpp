// Rays through the synthetic street.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "io/synth/street.hpp"
#include "io/synth/street_walker.hpp"
#include "io/synth/street_world.hpp"

namespace simuli {
namespace {

using Eigen::Vector3d;

/// Hits nearer than this are the surface the ray starts on.
constexpr double kStartTolerance_m = 1e-9;

/// Entry of the ray into the box nearer than `nearest.range`. A ray from inside meets nothing.
bool meet_box(const StreetSolid& solid,
              const Vector3d& origin,
              const Vector3d& direction,
              const Vector3d& inverse,
              StreetCrossing& nearest) {
  double enter = kStartTolerance_m;
  double leave = nearest.range;
  int axis = -1;
  for (int i = 0; i < 3; ++i) {
    if (direction[i] == 0.0) {
      if (!(origin[i] > solid.low[i] && origin[i] < solid.high[i])) return false;
      continue;
    }
    const double a = (solid.low[i] - origin[i]) * inverse[i];
    const double b = (solid.high[i] - origin[i]) * inverse[i];
    const double first = std::min(a, b);
    if (first > enter) {
      enter = first;
      axis = i;
    }
    leave = std::min(leave, std::max(a, b));
    if (!(enter < leave)) return false;
  }
  if (axis < 0) return false;
  nearest.range = enter;
  nearest.normal.setZero();
  nearest.normal[axis] = direction[axis] > 0.0 ? -1.0 : 1.0;
  return true;
}

bool meet_sphere(const StreetSolid& solid,
                 const Vector3d& origin,
                 const Vector3d& direction,
                 StreetCrossing& nearest) {
  const Vector3d from_centre = origin - solid.centre;
  const double half_b = from_centre.dot(direction);
  // The squared distance of the line from the centre, without the cancellation of b^2 - c.
  const double discriminant = solid.radius * solid.radius - (from_centre - half_b * direction).squaredNorm();
  if (!(discriminant > 0.0)) return false;
  const double range = -half_b - std::sqrt(discriminant);
  if (!(range > kStartTolerance_m && range < nearest.range)) return false;
  nearest.range = range;
  nearest.normal = (from_centre + range * direction) / solid.radius;
  return true;
}

/// Side and top of a vertical cylinder; its foot stands on the ground.
bool meet_pole(const StreetSolid& solid,
               const Vector3d& origin,
               const Vector3d& direction,
               StreetCrossing& nearest) {
  bool met = false;
  const Eigen::Vector2d from_axis = (origin - solid.centre).head<2>();
  const Eigen::Vector2d flat = direction.head<2>();
  const double speed2 = flat.squaredNorm();
  if (speed2 > 0.0) {
    const double closest = -from_axis.dot(flat) / speed2;
    const double discriminant = solid.radius * solid.radius - (from_axis + closest * flat).squaredNorm();
    if (discriminant > 0.0) {
      const double range = closest - std::sqrt(discriminant / speed2);
      const double z = origin.z() + range * direction.z();
      if (range > kStartTolerance_m && range < nearest.range && z >= solid.low.z() && z <= solid.high.z()) {
        nearest.range = range;
        nearest.normal << (from_axis + range * flat) / solid.radius, 0.0;
        met = true;
      }
    }
  }
  if (direction.z() < 0.0) {
    const double range = (solid.high.z() - origin.z()) / direction.z();
    const bool on_cap = (from_axis + range * flat).squaredNorm() < solid.radius * solid.radius;
    if (on_cap && range > kStartTolerance_m && range < nearest.range) {
      nearest.range = range;
      nearest.normal = Vector3d::UnitZ();
      met = true;
    }
  }
  return met;
}

/// A ball swept along the axis.
bool meet_rod(const StreetSolid& solid,
              const Vector3d& origin,
              const Vector3d& direction,
              StreetCrossing& nearest) {
  const double length2 = solid.axis.squaredNorm(), radius2 = solid.radius * solid.radius;
  const Vector3d arm = origin - solid.centre;
  bool met = false;
  const auto take = [&](double range, double place) {
    if (!(range > kStartTolerance_m && range < nearest.range)) return;
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
    if (!(discriminant > 0.0)) return false;  // its ends are no thicker
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

/// As meet_box(), of what the plane leaves.
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
  if (above_m < 0.0) {  // it leaves what is left at the plane, if ever
    if (!meets_box || (climb > 0.0 && whole.range >= plane)) return false;
    nearest = whole;
    return true;
  }
  if (meets_box && whole.range >= plane) {
    nearest = whole;
    return true;
  }
  const Vector3d point = origin + plane * direction;
  if (!(plane > kStartTolerance_m && plane < nearest.range)) return false;
  if ((point.array() < solid.low.array()).any() || (point.array() > solid.high.array()).any()) return false;
  nearest = {plane, solid.axis};
  return true;
}

/// Its face towards the ray.
bool meet_plate(const StreetSolid& solid,
                const Vector3d& origin,
                const Vector3d& direction,
                StreetCrossing& nearest) {
  if (direction.x() == 0.0) return false;
  const double range = (solid.centre.x() - origin.x()) / direction.x();
  if (!(range > kStartTolerance_m && range < nearest.range)) return false;
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

}  // namespace

bool meet_solid(const StreetSolid& solid,
                const Vector3d& origin,
                const Vector3d& direction,
                const Vector3d& inverse,
                StreetCrossing& nearest) {
  switch (solid.shape) {
    case StreetShape::kBox:
      return meet_box(solid, origin, direction, inverse, nearest);
    case StreetShape::kPole:
      return meet_pole(solid, origin, direction, nearest);
    case StreetShape::kSphere:
      return meet_sphere(solid, origin, direction, nearest);
    case StreetShape::kRod:
      return meet_rod(solid, origin, direction, nearest);
    case StreetShape::kCutBox:
      return meet_cut(solid, origin, direction, inverse, nearest);
    case StreetShape::kPlate:
      return meet_plate(solid, origin, direction, nearest);
  }
  return false;
}

double street_light(const Vector3d& normal) {
  static const Vector3d towards_sun = Vector3d(-0.45, -0.35, 0.82).normalized();
  return 0.62 + 0.43 * std::max(0.0, normal.dot(towards_sun));
}

Actor StreetCar::actor(double start_s, double end_s) const {
  constexpr double kKeyPeriod_s = 0.1;
  Actor car;
  car.name = "car";
  car.kind = "car";
  car.size_m = {2.0 * kCarHalfLength_m, 2.0 * kCarHalfWidth_m, kCarHeight_m};
  const int keys = static_cast<int>(std::ceil((end_s - start_s) / kKeyPeriod_s - 1e-9));
  for (int i = 0; i <= keys; ++i) {
    const double time_s = start_s + i * kKeyPeriod_s;
    const Vector3d middle = position(time_s) + Vector3d(0.0, 0.0, 0.5 * kCarHeight_m);
    car.track.push_back({time_s, {Eigen::Quaterniond::Identity(), middle}});
  }
  return car;
}

Street::Street(const StreetContents& contents)
    : contents_(contents), world_(std::make_shared<const StreetWorld>(build_street_world(contents))) {}

StreetHit Street::trace(const Vector3d& origin,
                        const Vector3d& direction,
                        double time_s,
                        double max_range) const {
  StreetHit hit;
  if (!(origin.allFinite() && direction.allFinite() && std::isfinite(time_s) && max_range > 0.0)) return hit;
  const Vector3d inverse = direction.cwiseInverse();
  StreetCrossing nearest;
  nearest.range = max_range;
  const StreetSolid* met = nullptr;
  for (const StreetSolid& solid : world_->ground) {
    if (meet_solid(solid, origin, direction, inverse, nearest)) met = &solid;
  }
  Vector3d solid_from_world = Vector3d::Zero();  // translation
  const Vector3d car_from_world =
      contents_.car ? Vector3d(-contents_.car->position(time_s)) : Vector3d::Zero();
  for (const StreetSolid& solid : world_->car) {
    if (meet_solid(solid, origin + car_from_world, direction, inverse, nearest)) {
      met = &solid;
      solid_from_world = car_from_world;
      hit.on_car = true;
    }
  }
  const StreetSolid* nearer = world_->index.meet(world_->solids, origin, direction, inverse, nearest);
  if (nearer != nullptr) {
    met = nearer;
    solid_from_world.setZero();
    hit.on_car = false;
  }
  if (contents_.walker) {
    const WalkerHit person = meet_walker(*contents_.walker, origin, direction, time_s, nearest.range);
    if (person.hit) {
      hit.hit = true;
      hit.on_car = false;
      hit.range = person.range;
      hit.normal = person.normal;
      hit.colour = (person.albedo * street_light(person.normal)).cwiseMax(0.0).cwiseMin(1.0);
      hit.reflectance = person.reflectance;
      return hit;
    }
  }
  if (met == nullptr) {
    hit.colour = street_sky(direction);
    return hit;
  }
  hit.hit = true;
  hit.range = nearest.range;
  hit.normal = nearest.normal;
  const Vector3d point = origin + nearest.range * direction + solid_from_world;
  // As wide as a pixel of the street's own camera, wider where the ray grazes the surface.
  constexpr double kPixel_rad = 0.0053, kLeastCosine = 0.3;
  const double footprint_m =
      kPixel_rad * nearest.range / std::max(std::abs(nearest.normal.dot(direction)), kLeastCosine);
  const StreetSurface surface =
      met->style == 0 ? street_surface(*met, point, nearest.normal, world_->seed)
                      : world_->detail->surface(*met, point, nearest.normal, world_->seed, footprint_m);
  hit.colour = (surface.albedo * street_light(nearest.normal)).cwiseMax(0.0).cwiseMin(1.0);
  hit.reflectance = surface.reflectance;
  return hit;
}

StreetReturn TracedWorld::lidar_return(const Vector3d& origin,
                                       const Vector3d& direction,
                                       double time_s,
                                       double range_min,
                                       double range_max) const {
  const StreetHit hit = trace(origin, direction, time_s, range_max);
  if (!(hit.hit && hit.range >= range_min)) return {};
  const double cosine = std::abs(hit.normal.dot(direction));
  if (!(hit.reflectance * cosine / (hit.range * hit.range) >= kMinimumEnergy)) return {};
  // A sensor compensates most of the inverse square; what is left halves the signal at 80 m.
  const double falloff = 1.0 / (1.0 + (hit.range / 80.0) * (hit.range / 80.0));
  return {hit.range, std::clamp(hit.reflectance * (0.3 + 0.7 * cosine) * falloff, 0.0, 1.0)};
}

}  // namespace simuli

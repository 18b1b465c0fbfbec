// Rays in the synthetic street.
#include <algorithm>
#include <cmath>

#include "io/synth/street.hpp"
#include "io/synth/street_walker.hpp"
#include "io/synth/street_world.hpp"

namespace simuli {

using Eigen::Vector3d;

bool meet_box(const StreetSolid& solid,
              const Vector3d& origin,
              const Vector3d& direction,
              const Vector3d& inverse,
              StreetCrossing& nearest) {
  double enter = kNearestHit_m;
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
                 const Vector3d& /*inverse*/,
                 StreetCrossing& nearest) {
  const Vector3d from_centre = origin - solid.centre;
  const double half_b = from_centre.dot(direction);
  // The squared distance of the line from the centre, without the cancellation in b^2 - c.
  const double discriminant = solid.radius * solid.radius - (from_centre - half_b * direction).squaredNorm();
  if (!(discriminant > 0.0)) return false;
  const double range = -half_b - std::sqrt(discriminant);
  if (!(range > kNearestHit_m && range < nearest.range)) return false;
  nearest.range = range;
  nearest.normal = (from_centre + range * direction) / solid.radius;
  return true;
}

bool meet_pole(const StreetSolid& solid,
               const Vector3d& origin,
               const Vector3d& direction,
               const Vector3d& /*inverse*/,
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
      if (range > kNearestHit_m && range < nearest.range && z >= solid.low.z() && z <= solid.high.z()) {
        nearest.range = range;
        nearest.normal << (from_axis + range * flat) / solid.radius, 0.0;
        met = true;
      }
    }
  }
  if (direction.z() < 0.0) {
    const double range = (solid.high.z() - origin.z()) / direction.z();
    const bool on_cap = (from_axis + range * flat).squaredNorm() < solid.radius * solid.radius;
    if (on_cap && range > kNearestHit_m && range < nearest.range) {
      nearest.range = range;
      nearest.normal = Vector3d::UnitZ();
      met = true;
    }
  }
  return met;
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
    if (solid.shape(solid, origin, direction, inverse, nearest)) met = &solid;
  }
  Vector3d solid_from_world = Vector3d::Zero();  // translation
  const Vector3d car_from_world =
      contents_.car ? Vector3d(-contents_.car->position(time_s)) : Vector3d::Zero();
  for (const StreetSolid& solid : world_->car) {
    if (solid.shape(solid, origin + car_from_world, direction, inverse, nearest)) {
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
  // The width of a pixel of the street's camera, larger at grazing incidence.
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
  // Sensors compensate most of the inverse square; the remainder halves the signal at 80 m.
  const double falloff = 1.0 / (1.0 + (hit.range / 80.0) * (hit.range / 80.0));
  return {hit.range, std::clamp(hit.reflectance * (0.3 + 0.7 * cosine) * falloff, 0.0, 1.0)};
}

}  // namespace simuli

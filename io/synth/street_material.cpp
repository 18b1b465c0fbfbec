// Appearance of the synthetic street's solids. Patterns have sizes of 0.1 m to 3 m and are smooth like real
// surfaces: Gaussians can represent them, but not per-pixel noise.
#include <algorithm>
#include <cmath>

#include "io/synth/street_pattern.hpp"
#include "io/synth/street_world.hpp"

namespace simuli {
namespace {

using Eigen::Vector3d;

using street_pattern::glass;
using street_pattern::hash;
using street_pattern::noise;
using street_pattern::patches;
using street_pattern::scaled;
using street_pattern::wrap;

StreetSurface asphalt(const StreetSolid& s, const Vector3d& p, std::uint64_t seed) {
  if (street_lane_marking(p.x(), p.y())) {
    const double worn = 1.0 + 0.08 * patches(p, 1.5, seed);
    return scaled({0.86, 0.86, 0.83}, 0.75, worn);
  }
  // Wheel tracks are slightly darker than the lane's centre.
  const double track = std::cos(2.0 * 3.14159265358979 * (std::abs(p.y()) - 1.75) / 1.6);
  return scaled(s.tint, s.reflectance, 1.0 + 0.16 * patches(p, 2.4, seed) + 0.05 * track);
}

StreetSurface pavement(const StreetSolid& s, const Vector3d& p, const Vector3d& normal, std::uint64_t seed) {
  const double side = std::abs(p.y());
  if (side < kRoadHalfWidth_m + 0.2 || normal.z() < 0.5) {  // kerb stones of 1 m
    const double stone = hash(static_cast<std::int64_t>(std::floor(p.x())), p.y() > 0.0 ? 1 : 0, 0, seed);
    return scaled({0.70, 0.69, 0.66}, 0.35, 0.92 + 0.16 * stone);
  }
  if (side > kFacadeLine_m + 1.2) return scaled({0.30, 0.40, 0.20}, 0.35, 1.0 + 0.2 * patches(p, 1.2, seed));
  const auto slab_x = static_cast<std::int64_t>(std::floor(p.x() / 1.2));
  const auto slab_y = static_cast<std::int64_t>(std::floor(side / 0.8));
  const double slab = hash(slab_x, slab_y, p.y() > 0.0 ? 1 : 0, seed + 7);
  return scaled(s.tint, s.reflectance, 0.9 + 0.2 * slab + 0.06 * patches(p, 1.0, seed));
}

StreetSurface facade(const StreetSolid& s, const Vector3d& p, const Vector3d& normal, std::uint64_t seed) {
  const double height = s.high.z();
  const bool street_side = std::abs(normal.y()) > 0.5;
  const double wall = 1.0 + 0.18 * patches(p, 2.5, seed) + (wrap(p.z(), 0.6) < 0.3 ? 0.03 : -0.03);
  if (normal.z() > 0.5) return scaled({0.40, 0.36, 0.34}, 0.25, wall);
  if (p.z() > height - 0.5) return scaled(0.55 * s.tint + Vector3d::Constant(0.3), 0.5, 1.0);  // cornice
  if (p.z() < 0.7) return scaled(0.5 * s.tint, 0.25, wall);                                    // plinth
  if (!street_side) return scaled(s.tint, s.reflectance, wall);
  // Storeys of 3 m and bays of about 2.4 m, fitted to the house's width.
  const auto [bays, bay] = street_bays(s);
  const double u = p.x() - s.low.x();
  const double across = std::abs(wrap(u, bay) - 0.5 * bay);
  const double storey = std::floor(p.z() / 3.0);
  const double up = p.z() - 3.0 * storey;
  if (3.0 * (storey + 1.0) > height - 0.4) return scaled(s.tint, s.reflectance, wall);
  const auto column = static_cast<std::int64_t>(std::floor(u / bay));
  const double lit =
      hash(column, static_cast<std::int64_t>(storey), static_cast<std::int64_t>(s.low.x() * 16.0), seed);
  if (storey == 0.0 && column == bays / 2) {  // a door of painted wood
    if (across < 0.55 && up < 2.3) return scaled({0.36, 0.20 + 0.15 * lit, 0.14}, 0.3, wall);
    return scaled(s.tint, s.reflectance, wall);
  }
  const double half_width = 0.58;
  if (across < half_width + 0.1 && up > 0.8 && up < 2.4) {
    const bool frame = across > half_width || across < 0.04 || up < 0.9 || up > 2.3;
    if (frame) return scaled({0.88, 0.87, 0.84}, 0.55, 1.0);
    return glass(0.7 + 0.6 * lit + 0.25 * (up - 0.9));
  }
  return scaled(s.tint, s.reflectance, wall);
}

StreetSurface car_body(const StreetSolid& s, const Vector3d& p, const Vector3d& normal) {
  const Vector3d q = p - s.centre;  // in the car's frame
  if (std::abs(normal.y()) > 0.5) {
    const double wheel = std::hypot(std::abs(q.x()) - 1.3, q.z() - 0.32);
    if (wheel < 0.18) return scaled({0.60, 0.61, 0.63}, 0.4, 1.0);  // rim
    if (wheel < 0.34) return scaled({0.06, 0.06, 0.07}, 0.05, 1.0);
  }
  if (std::abs(normal.x()) > 0.5) {
    const bool lamp = std::abs(q.y()) > 0.55 && q.z() > 0.6 && q.z() < 0.82;
    if (lamp && normal.x() < 0.0) return scaled({0.80, 0.08, 0.06}, 0.9, 1.0);
    if (lamp) return scaled({0.95, 0.95, 0.88}, 0.9, 1.0);
    if (std::abs(q.y()) < 0.27 && q.z() > 0.42 && q.z() < 0.54) return scaled({0.9, 0.9, 0.88}, 0.95, 1.0);
  }
  // Paint is darker towards the sill.
  return scaled(s.tint, s.reflectance, 0.8 + 0.25 * (q.z() - 0.26));
}

StreetSurface car_cabin(const StreetSolid& s, const Vector3d& p, const Vector3d& normal) {
  const Vector3d q = p - s.centre;
  if (normal.z() > 0.5) return scaled(s.tint, s.reflectance, 1.0);
  const bool rail = q.z() > 1.40 || q.z() < 0.96;
  const bool pillar = std::abs(normal.y()) > 0.5
                          ? q.x() < -1.43 || q.x() > 0.85 || std::abs(q.x() + 0.3) < 0.06
                          : std::abs(q.y()) > 0.68;
  return rail || pillar ? scaled(s.tint, s.reflectance, 0.9) : glass(0.6 + 0.8 * (q.z() - 0.92));
}

StreetSurface sign(const StreetSolid& s, const Vector3d& p, const Vector3d& normal) {
  if (normal.x() > -0.5) return scaled({0.55, 0.56, 0.57}, 0.4, 1.0);  // bare back and edges
  const double across = std::hypot(p.y() - s.centre.y(), p.z() - s.centre.z());
  if (across < 0.22) return scaled({0.93, 0.93, 0.92}, 0.95, 1.0);
  return scaled(s.tint, 0.85, 1.0);
}

}  // namespace

bool street_lane_marking(double x, double y) {
  const double side = std::abs(y);
  if (side < 0.08) return wrap(x, 6.0) < 3.0;            // dashed centre line
  if (std::abs(side - kLaneEdge_m) < 0.06) return true;  // edge of the parking lane
  if (side > kLaneEdge_m && side < kRoadHalfWidth_m && wrap(x, 7.0) < 0.1) return true;  // parking bays
  const bool crossing = wrap(x - 36.0, 80.0) < 3.0;
  return crossing && side < kLaneEdge_m && wrap(y + 0.25, 1.0) < 0.5;
}

StreetBays street_bays(const StreetSolid& house) {
  const double width = house.high.x() - house.low.x();
  const int count = std::max(1, static_cast<int>(std::floor(width / 2.4)));
  return {count, width / count};
}

StreetSurface street_surface(const StreetSolid& solid,
                             const Vector3d& point,
                             const Vector3d& normal,
                             std::uint64_t seed) {
  switch (solid.material) {
    case StreetMaterial::kAsphalt:
      return asphalt(solid, point, seed);
    case StreetMaterial::kPavement:
      return pavement(solid, point, normal, seed);
    case StreetMaterial::kFacade:
      return facade(solid, point, normal, seed);
    case StreetMaterial::kCarBody:
      return car_body(solid, point, normal);
    case StreetMaterial::kCarCabin:
      return car_cabin(solid, point, normal);
    case StreetMaterial::kTyre:
      return scaled({0.06, 0.06, 0.07}, 0.05, 1.0);
    case StreetMaterial::kMetal:
      return scaled(solid.tint, solid.reflectance, 1.0);
    case StreetMaterial::kSign:
      return sign(solid, point, normal);
    case StreetMaterial::kBark:
      return scaled(solid.tint, solid.reflectance, 1.0 + 0.2 * noise(point * 3.0, seed));
    case StreetMaterial::kLeaves:
      return scaled(solid.tint, solid.reflectance, 1.0 + 0.35 * noise(point * 2.2, seed));
    default:
      return scaled(solid.tint, solid.reflectance, 1.0);  // only of a detail
  }
}

Vector3d street_sky(const Vector3d& direction) {
  const double up = std::clamp(direction.z(), 0.0, 1.0);
  const Vector3d horizon(0.82, 0.86, 0.90);
  const Vector3d zenith(0.30, 0.50, 0.82);
  // Warm light from the direction of travel, and slow clouds.
  const double warm = 0.06 * std::max(0.0, direction.x()) * (1.0 - up);
  const double cloud = 0.04 * std::sin(5.0 * direction.x() + 3.0 * direction.y()) * std::sin(7.0 * up);
  const Vector3d blue = horizon + std::sqrt(up) * (zenith - horizon);
  return (blue + Vector3d(warm, 0.5 * warm, -0.5 * warm) + Vector3d::Constant(cloud))
      .cwiseMax(0.0)
      .cwiseMin(1.0);
}

}  // namespace simuli

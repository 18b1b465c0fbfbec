// Walls of the detailed street: brick, stone, render and boards; windows with interiors; shops.
#include <algorithm>
#include <array>
#include <cmath>

#include "bench/street/detail.hpp"
#include "bench/street/detail_pattern.hpp"

namespace simuli::bench {
namespace {

using Eigen::Vector3d;
using street_pattern::cell;
using street_pattern::ease;
using street_pattern::fine;
using street_pattern::glass;
using street_pattern::hash;
using street_pattern::noise;
using street_pattern::patches;
using street_pattern::scaled;
using street_pattern::wrap;

/// Returns a pattern of stones of size a x b in rows, each offset by half a stone; u along the wall.
double masonry(
    double u, double z, double a, double b, double contrast, std::uint64_t seed, double footprint_m) {
  const auto row = cell(z, b);
  const double shifted = u + 0.5 * a * static_cast<double>(row & 1);
  const double stone = hash(cell(shifted, a), row, 0, seed) - 0.5;
  const double at_u = wrap(shifted, a), at_z = wrap(z, b);
  const double edge = std::min({at_u, a - at_u, at_z, b - at_z});
  const double joint_m = 0.25 * b;
  // Subtracts the mean of the joints, so that far and near walls are equally bright.
  const double joint = 1.0 - ease(0.0, joint_m, edge) - joint_m * (1.0 / a + 1.0 / b);
  return fine(b, footprint_m) * (contrast * stone + 0.18 * joint);
}

double wall_at(const StreetSolid& s, double u, const Vector3d& p, std::uint64_t seed, double footprint_m) {
  constexpr std::uint32_t kBits = 8;
  const std::uint32_t kind = (s.style - 1) % kBits;
  double tone = 1.0 + 0.12 * patches(p, 2.5, seed) + 0.06 * noise(p / 0.5, seed + 51);
  // Streaks of rain, and dust near the ground.
  const Vector3d drawn(p.x() / 0.35, p.y() / 0.35, p.z() / 2.6);
  tone -= 0.16 * ease(0.1, 0.8, noise(drawn, seed + 52)) + 0.15 * (1.0 - ease(0.2, 1.6, p.z()));
  switch (kind) {
    case 0:  // render with damaged spots
      if (noise(p / 0.9, seed + 53) > 0.62)
        tone *= 0.82 + masonry(u, p.z(), 0.25, 0.083, 0.3, seed, footprint_m);
      return tone + 0.04 * fine(0.12, footprint_m) * noise(p / 0.12, seed + 54);
    case 1:
      return tone * (1.0 + masonry(u, p.z(), 0.25, 0.083, 0.55, seed, footprint_m));
    case 2:
      return tone * (1.0 + masonry(u, p.z(), 0.8, 0.4, 0.22, seed, footprint_m));
    case 3:  // brick with lighter courses
      return tone *
             (wrap(p.z(), 1.0) < 0.17 ? 1.25 : 1.0 + masonry(u, p.z(), 0.24, 0.1, 0.45, seed, footprint_m));
    default: {  // boards
      const double up = wrap(p.z(), 0.18) / 0.18;
      return tone * (1.0 + fine(0.09, footprint_m) * (0.22 * (up - 0.5) - (up < 0.12 ? 0.25 : -0.03)));
    }
  }
}

/// Returns the view through a window, relative to its middle and foot, m. Panes have no LiDAR return.
StreetSurface window(double across, double up, double tall, double lit, double kind, double footprint_m) {
  const double to_frame = std::abs(across);
  constexpr double kHalf_m = 0.58;
  const bool is_frame = to_frame > kHalf_m - 0.05 || to_frame < 0.03 || up < 0.06 || up > tall - 0.06 ||
                        std::abs(up - 0.68 * tall) < 0.025;
  if (is_frame) return scaled({0.88, 0.87, 0.84}, 0.55, 1.0);
  StreetSurface pane = glass(0.5 + 0.5 * lit + 0.25 * up);
  const double shade = 0.55 + 0.45 * ease(0.0, 0.3, tall - up);  // shade of the lintel
  if (kind < 0.35) {                                             // curtains with folds at both sides
    const double open = 0.12 + 0.3 * lit;
    if (to_frame > open) {
      const double folds = std::sin(2.0 * 3.14159265358979 * across / 0.13);
      pane.albedo = Vector3d(0.66, 0.62, 0.52) * (0.85 + 0.18 * fine(0.06, footprint_m) * folds);
    }
  } else if (kind < 0.55) {  // a partly lowered blind
    if (tall - up < 0.3 + 1.0 * lit) {
      const double slats = std::sin(2.0 * 3.14159265358979 * up / 0.1);
      pane.albedo = Vector3d(0.60, 0.58, 0.55) * (0.9 + 0.2 * fine(0.05, footprint_m) * slats);
    }
  } else if (kind < 0.65) {  // objects on the sill
    const double thing = hash(cell(across + 5.0, 0.17), 0, 0, static_cast<std::uint64_t>(1e6 * lit));
    if (up < 0.1 + 0.4 * thing && thing > 0.35) pane.albedo = Vector3d(0.30, 0.34 + 0.2 * thing, 0.22);
  }
  pane.albedo *= shade;
  return pane;
}

/// Returns a shop's ground floor: large panes with goods behind, or a closed shutter.
StreetSurface shop_front(const StreetSolid& s,
                         std::int64_t column,
                         double across,
                         double half,
                         double up,
                         bool is_door,
                         std::uint64_t seed,
                         double footprint_m) {
  const std::uint64_t own = seed + s.style;
  const double closed = hash(column, 3, static_cast<std::int64_t>(16.0 * s.low.x()), own + 64);
  if (up < 0.45 && !is_door)
    return scaled({0.26, 0.25, 0.25}, 0.3, 1.0 + 0.15 * noise({across / 0.4, up / 0.2, 0.0}, own));
  if (std::abs(across) > half - 0.07 || std::abs(up - 2.15) < 0.04 ||
      (is_door && std::abs(across) > 0.55 && std::abs(across) < 0.63)) {
    return scaled({0.30, 0.31, 0.30}, 0.35, 1.0);
  }
  if (closed < 0.16 && !is_door) {
    const double ribs = std::sin(2.0 * 3.14159265358979 * up / 0.12);
    const double sprayed = noise({across / 0.5, up / 0.4, static_cast<double>(column)}, own + 61);
    const Vector3d tint = std::abs(sprayed) < 0.13 ? Vector3d(0.20, 0.30, 0.62) : Vector3d(0.58, 0.58, 0.56);
    return scaled(tint, 0.4, 1.0 + 0.14 * fine(0.06, footprint_m) * ribs);
  }
  StreetSurface pane = glass(0.7 + 0.3 * up);
  if (is_door && std::abs(across) < 0.55) {
    if (std::abs(across) > 0.45 || up < 0.25) return scaled({0.32, 0.24, 0.18}, 0.3, 1.0);
    return pane;
  }
  // Shelves of goods.
  const double shelf = wrap(up - 0.45, 0.42);
  const auto row = cell(up - 0.45, 0.42), item = cell(across + 9.0, 0.19);
  const double thing = hash(item, row, column, own + 62);
  if (shelf < 0.03) {
    pane.albedo = {0.55, 0.50, 0.42};
  } else if (up < 1.75 && thing > 0.25 && shelf < 0.12 + 0.24 * thing) {
    const double hue = hash(item, row, column, own + 63);
    // Goods of one shop have similar colours.
    const Vector3d brand(0.2 + 0.7 * hash(static_cast<std::int64_t>(own % 97), 1, 0, seed),
                         0.2 + 0.6 * hash(static_cast<std::int64_t>(own % 97), 2, 0, seed),
                         0.2 + 0.5 * hash(static_cast<std::int64_t>(own % 97), 3, 0, seed));
    pane.albedo = 0.6 * brand + 0.4 * Vector3d(0.15 + 0.7 * hue, 0.15 + 0.7 * thing, 0.85 - 0.7 * hue);
  } else if (up > 1.2) {
    pane.albedo += 0.25 * Vector3d(1.0, 0.9, 0.65) * ease(1.2, 2.4, up);  // interior light
  }
  return pane;
}

}  // namespace

StreetSurface detail_facade(
    const StreetSolid& s, const Vector3d& p, const Vector3d& normal, std::uint64_t seed, double footprint_m) {
  if (normal.z() > 0.5) return scaled({0.40, 0.36, 0.34}, 0.25, 1.0 + 0.15 * patches(p, 2.0, seed));
  const bool faces_street = std::abs(normal.y()) > 0.5;
  const double u = faces_street ? p.x() - s.low.x() : p.y();
  const double wall = wall_at(s, u, p, seed, footprint_m);
  const double height = s.high.z();
  if (p.z() > height - 0.5) return scaled(0.55 * s.tint + Vector3d::Constant(0.3), 0.5, 0.5 + 0.5 * wall);
  const bool is_shop = faces_street && ((s.style - 1) & 8U) != 0;
  const auto [bays, bay] = street_bays(s);
  const auto column = cell(u, bay);
  const double from_middle = wrap(u, bay) - 0.5 * bay;
  const std::int64_t own = static_cast<std::int64_t>(s.low.x() * 16.0);
  if (is_shop && p.z() < 2.75 && u > 0.35 && s.high.x() - p.x() > 0.35) {
    return shop_front(s, column, from_middle, 0.5 * bay, p.z(), column == bays / 2, seed, footprint_m);
  }
  if (p.z() < 0.7) {
    const double blocks = masonry(u, p.z(), 0.9, 0.35, 0.2, seed + 3, footprint_m);
    return scaled(0.35 * s.tint + Vector3d::Constant(0.12), 0.25, wall + blocks);
  }
  const StreetSurface bare = scaled(s.tint, s.reflectance, wall);
  const double storey = std::floor(p.z() / 3.0), up = p.z() - 3.0 * storey;
  if (!faces_street || 3.0 * (storey + 1.0) > height - 0.4) return bare;
  const double lit = hash(column, static_cast<std::int64_t>(storey), own, seed);
  if (storey == 0.0 && column == bays / 2) {  // a wooden panelled door with a window above
    const double out = std::abs(from_middle);
    if (out > 0.62 || up > 2.42) return bare;
    if (out > 0.54 || up > 2.34) return scaled({0.82, 0.80, 0.76}, 0.5, 1.0);
    if (up > 2.05) return glass(0.9);
    const bool is_panel = wrap(out, 0.5) > 0.1 && wrap(out, 0.5) < 0.42 && wrap(up - 0.5, 0.75) > 0.12;
    const Vector3d wood(0.36 - 0.2 * lit, 0.20 + 0.15 * lit, 0.14 + 0.2 * (1.0 - lit));
    return scaled(wood, 0.3, is_panel ? 0.85 : 1.05);
  }
  if (std::abs(from_middle) < 0.58 && up > 0.8 && up < 2.4) {
    return window(from_middle,
                  up - 0.8,
                  1.6,
                  lit,
                  hash(column, static_cast<std::int64_t>(storey), own, seed + 9),
                  footprint_m);
  }
  // Posters on the piers, and the house number at the door.
  const double pier = std::abs(from_middle) - 0.5 * bay;
  if (storey == 0.0 && pier > -0.30 && up > 1.0 && up < 1.85) {
    const auto at = cell(u + 0.5 * bay, bay);
    const double bill = hash(at, 7, own, seed + 10);
    if (bill < 0.3 && u > 0.5 && s.high.x() - p.x() > 0.5) {
      const double line = wrap(up, 0.17);
      const Vector3d paper(0.9 - bill, 0.55 + bill, 0.85 - 2.0 * bill);
      return scaled(line < 0.07 && up > 1.15 ? Vector3d(0.18, 0.16, 0.22) : paper, 0.5, 1.0);
    }
  }
  return bare;
}

}  // namespace simuli::bench

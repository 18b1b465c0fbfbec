// Road and pavement of the detailed street: old and new markings, repairs, cracks, covers; slabs and setts.
#include <algorithm>
#include <cmath>

#include "bench/street/detail.hpp"
#include "bench/street/detail_pattern.hpp"

namespace simuli::bench {
namespace {

using Eigen::Vector3d;
using street_pattern::cell;
using street_pattern::ease;
using street_pattern::fine;
using street_pattern::hash;
using street_pattern::ink;
using street_pattern::noise;
using street_pattern::patches;
using street_pattern::scaled;
using street_pattern::wrap;

/// Returns a line along the zeros of a noise: 1 on the line, 0 farther than half its width.
double vein(const Vector3d& p, double size_m, double width_m, std::uint64_t seed) {
  const double slope = 1.6 / size_m;  // approximate slope of the noise
  return 1.0 - ease(0.25 * width_m, 0.75 * width_m, std::abs(noise(p / size_m, seed)) / slope);
}

/// Whether (a, b) is on a lane arrow of 4.2 m; a: along the lane, b: to the driver's right.
bool is_arrow(double a, double b, bool turns) {
  if (a < 0.0 || a > 4.2) return false;
  if (!turns) return a < 2.6 ? std::abs(b) < 0.09 : std::abs(b) < 0.42 * (4.2 - a) / 1.6;
  if (a < 2.4 && std::abs(b) < 0.09) return true;
  if (a > 2.05 && a < 2.4 && b >= 0.0 && b < 0.55) return true;
  return b >= 0.55 && b < 1.1 && std::abs(a - 2.22) < 1.2 * (1.1 - b);
}

/// Whether (a, b) is on a bicycle symbol, stretched along the road.
bool is_bicycle(double a, double b) {
  const double long_a = a / 1.7;  // the height of the symbol is along the road
  const auto ring = [&](double middle) {
    const double r = std::hypot(long_a - 0.30, b - middle);
    return r > 0.19 && r < 0.27;
  };
  const auto bar = [&](double a0, double b0, double a1, double b1) {
    const double da = a1 - a0, db = b1 - b0;
    const double t = std::clamp(((long_a - a0) * da + (b - b0) * db) / (da * da + db * db), 0.0, 1.0);
    return std::hypot(long_a - a0 - t * da, b - b0 - t * db) < 0.035;
  };
  return ring(-0.35) || ring(0.35) || bar(0.30, -0.35, 0.72, -0.14) || bar(0.72, -0.14, 0.68, 0.24) ||
         bar(0.68, 0.24, 0.30, 0.35) || bar(0.72, -0.14, 0.32, 0.02) || bar(0.32, 0.02, 0.68, 0.24) ||
         bar(0.68, 0.24, 0.86, 0.2) || bar(0.82, -0.16, 0.82, -0.02);
}

/// Whether (x, y) is on a marking.
bool is_paint(double x, double y) {
  if (street_lane_marking(x, y)) return true;
  const double side = std::abs(y), drives = y < 0.0 ? 1.0 : -1.0;
  const double past = wrap(drives * x, 1e6);
  // offset from the lane's middle towards the road's middle, the driver's left
  const double right = 1.75 - side;
  // Stop lines before the crossings.
  const double from_crossing = wrap(x - kCrossingFirst_m, kCrossingEvery_m);
  const bool is_stop = y < 0.0
                           ? from_crossing > kCrossingEvery_m - 2.4 && from_crossing < kCrossingEvery_m - 2.0
                           : from_crossing > kCrossingLong_m + 2.0 && from_crossing < kCrossingLong_m + 2.4;
  if (is_stop && side > 0.15 && side < 3.4) return true;
  // Arrows and the speed limit, every 40 m each.
  const double along = wrap(past - 9.0, 40.0);
  const auto lap = cell(past - 9.0, 40.0);
  if (side < 3.2 && is_arrow(along, -right, lap % 3 == 1)) return true;
  const double text = wrap(past - 19.0, 40.0);
  if (text < 2.4 && std::abs(right) < 0.5 && ink("30", (-right + 0.5) / 0.5, text / 2.4)) return true;
  // A bicycle lane at the right with a dashed line.
  if (wrap(past + 12.0, 120.0) < 84.0) {
    if (std::abs(side - 2.55) < 0.05) return wrap(x, 2.0) < 1.0;
    if (side > 2.6 && side < 3.45 && is_bicycle(wrap(past - 4.0, 16.0) - 0.2, side - 3.03)) return true;
  }
  if (side > 3.6 && side < 5.15) {
    // A hatched no-parking area before the crossings.
    const double hatched = wrap(drives * (x - kCrossingFirst_m - 1.5) + 8.0, kCrossingEvery_m);
    if (hatched < 5.5) {
      return wrap(x + y, 1.2) < 0.22 || hatched < 0.12 || hatched > 5.38 || side < 3.72 || side > 5.03;
    }
    const auto bay = cell(x, 7.0);
    if (hash(bay, y > 0.0 ? 1 : 0, 3, 17) < 0.35) {
      const double u = wrap(x, 7.0) - 3.0, v = (side - 3.9) / 0.9;
      return u >= 0.0 && v >= 0.0 && v < 1.0 && ink("P", u / 0.7, v);
    }
  }
  return false;
}

/// Returns the brightness of repairs: rectangles of other asphalt with a tar seam, and trenches across the
/// road.
double repaired(const Vector3d& p, std::uint64_t seed, double footprint_m, double& seam) {
  double tone = 1.0;
  const auto i = cell(p.x(), 7.0), j = cell(p.y(), 1.9);
  const auto dice = [&](std::int64_t k) { return hash(i, j, k, seed + 31); };
  if (dice(0) < 0.42) {
    const double half_x = 0.4 + 2.4 * dice(1), half_y = 0.3 + 0.6 * dice(2);
    const double dx = std::abs(wrap(p.x(), 7.0) - 3.5) - half_x,
                 dy = std::abs(wrap(p.y(), 1.9) - 0.95) - half_y;
    const double out = std::max(dx, dy);
    if (out < 0.0) tone = dice(3) < 0.65 ? 0.74 : 1.22;
    seam = std::max(seam, fine(0.06, footprint_m) * (1.0 - ease(0.01, 0.05, std::abs(out))));
  }
  const auto trench = cell(p.x(), 23.0);
  if (hash(trench, 0, 5, seed) < 0.6) {
    const double at = std::abs(wrap(p.x(), 23.0) - 4.0 - 15.0 * hash(trench, 1, 5, seed));
    if (at < 0.35) tone *= 0.82;
    seam = std::max(seam, fine(0.06, footprint_m) * (1.0 - ease(0.01, 0.05, std::abs(at - 0.35))));
  }
  return tone;
}

/// Returns 1 on the rim and 2 inside of an iron cover in a lane; 0: no cover.
int cover_at(double x, double y, double radius, double every, std::uint64_t seed) {
  const auto i = cell(x, every);
  const auto side = y > 0.0 ? 1 : 0;
  const double at_x = every * (0.2 + 0.6 * hash(i, side, 1, seed)), at_y = 0.5 + 2.2 * hash(i, side, 2, seed);
  const double r = std::hypot(wrap(x, every) - at_x, std::abs(y) - at_y);
  return r > radius ? 0 : r > 0.8 * radius ? 1 : 2;
}

}  // namespace

StreetSurface detail_road(const StreetSolid& s, const Vector3d& p, std::uint64_t seed, double footprint_m) {
  const double side = std::abs(p.y());
  if (side > 5.2 && side < kKerbBack_m) {  // the gutter: two rows of stones with grates
    const double grate = std::abs(wrap(p.x() - 3.0, 12.5) - 1.0);
    if (grate < 0.26 && side < 5.48) {
      const double bars = 0.5 + 0.5 * std::cos(2.0 * 3.14159265358979 * p.x() / 0.13);
      return scaled({0.20, 0.20, 0.21}, 0.12, 0.75 + 0.7 * fine(0.065, footprint_m) * (bars - 0.5));
    }
    const double row = side < 5.35 ? 0.0 : 0.15;
    const double stone = hash(cell(p.x() + row, 0.3), cell(side, 0.15), p.y() > 0.0 ? 1 : 0, seed + 21);
    const double joint = std::min(wrap(p.x() + row, 0.3), 0.3 - wrap(p.x() + row, 0.3)) < 0.02 ? 0.7 : 1.0;
    const double sharp = fine(0.15, footprint_m);
    return scaled({0.50, 0.49, 0.47}, 0.28, 1.0 + 0.4 * sharp * (stone - 0.5) + 0.5 * sharp * (joint - 0.96));
  }
  // Wheel tracks are slightly darker than the middle of the lane; parking lanes have stains.
  const double track = std::cos(2.0 * 3.14159265358979 * (side - 1.75) / 1.6);
  double tone = 1.0 + 0.16 * patches(p, 2.4, seed) + (side < 3.5 ? 0.07 * track : 0.0);
  const double grain =
      0.17 * fine(0.16, footprint_m) * noise(p / 0.16, seed + 11) + 0.13 * noise(p / 0.45, seed + 12);
  double seam = 0.0;
  tone = tone * repaired(p, seed, footprint_m, seam) + grain;
  if (side > 3.6) tone *= 1.0 - 0.35 * ease(0.35, 0.65, noise(p / 0.9, seed + 13));
  const double cracked = ease(0.0, 0.25, noise(p / 6.0, seed + 14));
  double crack = cracked * fine(0.05, footprint_m) * vein(p, 1.3, 0.07, seed + 15);
  crack = std::max(
      crack,
      ease(0.1, 0.3, noise(p / 9.0, seed + 16)) * fine(0.08, footprint_m) * vein(p, 3.1, 0.12, seed + 17));
  const double dark = std::max(crack, seam);
  StreetSurface surface = scaled(s.tint, s.reflectance, tone * (1.0 - 0.55 * dark));
  const int cover = side < 3.4 ? cover_at(p.x(), p.y(), 0.34, 19.0, seed + 18) : 0;
  if (cover > 0) {
    const bool knob = (cell(p.x(), 0.11) + cell(p.y(), 0.11)) % 2 == 0;
    const double relief = 0.3 * fine(0.11, footprint_m) * (knob ? 1.0 : -1.0);
    return scaled(cover == 1 ? Vector3d(0.44, 0.42, 0.40) : Vector3d(0.27, 0.25, 0.24),
                  0.22,
                  cover == 1 ? 1.0 : 1.0 + relief);
  }
  const bool is_red = wrap((p.y() < 0.0 ? p.x() : -p.x()) - 44.0, 80.0) < 16.0 && side > 2.6 && side < 3.44;
  if (is_red) surface = scaled({0.50, 0.24, 0.20}, 0.2, tone * (1.0 - 0.3 * dark));
  if (is_paint(p.x(), p.y())) {
    // Worn in wheel tracks and in spots.
    const double wear = noise(p / 0.35, seed + 19) + 0.8 * noise(p / 1.7, seed + 20) + 0.25 * track;
    const double left = (1.0 - 0.75 * ease(0.15, 0.85, wear)) * (1.0 - 0.6 * crack);
    const StreetSurface paint = scaled({0.86, 0.86, 0.83}, 0.75, 1.0 + 0.08 * patches(p, 1.5, seed));
    surface.albedo += left * (paint.albedo - surface.albedo);
    surface.reflectance += left * (paint.reflectance - surface.reflectance);
  }
  return surface;
}

StreetSurface detail_pavement(
    const StreetSolid& s, const Vector3d& p, const Vector3d& normal, std::uint64_t seed, double footprint_m) {
  const double side = std::abs(p.y());
  const std::int64_t which = p.y() > 0.0 ? 1 : 0;
  const double dirt = 1.0 + 0.10 * patches(p, 1.4, seed + 41) + 0.08 * noise(p / 0.3, seed + 42);
  constexpr std::uint32_t kKerbStyle = 2, kTactile = 3;
  if (s.style == kKerbStyle || normal.z() < 0.3) {
    const double stone = hash(cell(p.x()), which, 0, seed),
                 end = std::min(wrap(p.x(), 1.0), 1.0 - wrap(p.x(), 1.0));
    const double joint = fine(0.05, footprint_m) * (1.0 - ease(0.008, 0.03, end));
    return scaled({0.70, 0.69, 0.66}, 0.35, (0.88 + 0.2 * stone) * dirt * (1.0 - 0.4 * joint));
  }
  if (s.style == kTactile) {
    const double knobs =
        std::cos(2.0 * 3.14159265358979 * p.x() / 0.2) * std::cos(2.0 * 3.14159265358979 * p.y() / 0.2);
    return scaled({0.78, 0.72, 0.50}, 0.45, dirt + 0.18 * fine(0.1, footprint_m) * knobs);
  }
  if (side > kFacadeLine_m + 1.2) {
    return scaled(
        {0.30, 0.40, 0.20}, 0.35, 1.0 + 0.2 * patches(p, 1.2, seed) + 0.12 * noise(p / 0.2, seed + 43));
  }
  const double sharp = fine(0.12, footprint_m);
  if (side < 6.75 || side > 8.6) {  // rows of small stones beside the slabs
    const double shift = 0.1 * static_cast<double>(cell(side, 0.2) % 2);
    const double stone = hash(cell(p.x() + shift, 0.2), cell(side, 0.2), which, seed + 44);
    const double edge = std::min(
        {wrap(p.x() + shift, 0.2), 0.2 - wrap(p.x() + shift, 0.2), wrap(side, 0.2), 0.2 - wrap(side, 0.2)});
    const double joint = 1.0 - ease(0.0, 0.03, edge);
    return scaled(
        {0.50, 0.47, 0.44}, 0.28, dirt * (1.0 + 0.45 * sharp * (stone - 0.5) - 0.35 * sharp * (joint - 0.1)));
  }
  const auto row = cell(side, 0.6);
  const double shift = 0.3 * static_cast<double>(row % 2);
  const double slab = hash(cell(p.x() + shift, 0.6), row, which, seed + 7);
  const double edge = std::min(
      {wrap(p.x() + shift, 0.6), 0.6 - wrap(p.x() + shift, 0.6), wrap(side, 0.6), 0.6 - wrap(side, 0.6)});
  const double joint = fine(0.05, footprint_m) * (1.0 - ease(0.008, 0.03, edge));
  const int cover = side > 7.0 && side < 8.4 ? cover_at(p.x(), side - 6.6, 0.22, 13.0, seed + 45) : 0;
  if (cover > 0) return scaled({0.33, 0.32, 0.31}, 0.25, cover == 1 ? 1.2 : 0.9 * dirt);
  const double spots = 1.0 - 0.35 * fine(0.1, footprint_m) * ease(0.55, 0.75, noise(p / 0.22, seed + 46));
  const double new_slab = hash(cell(p.x() + shift, 0.6), row, which, seed + 8) < 0.07 ? 1.18 : 1.0;
  return scaled(s.tint, s.reflectance, (0.86 + 0.26 * slab) * dirt * new_slab * spots * (1.0 - 0.4 * joint));
}

}  // namespace simuli::bench

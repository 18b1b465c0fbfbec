// Objects of the detailed street along the pavements' edges, in gaps between parked cars, at crossings and
// above the road.
#include <algorithm>
#include <array>
#include <cmath>

#include "bench/street/detail.hpp"
#include "io/synth/street.hpp"

namespace simuli::bench {
namespace {

using Eigen::Vector3d;

constexpr double kFurnitureStart_m = -52.0, kFurnitureEnd_m = Street::kLength_m + 74.0;
constexpr double kTop_m = kKerbHeight_m;
constexpr double kEdge_m = 5.90;  // objects on the kerb
const Vector3d kSteel(0.50, 0.51, 0.52), kDark(0.15, 0.17, 0.17), kGreen(0.16, 0.30, 0.22);

void add_railing(StreetSide& to, double x0, double x1, double y) {
  constexpr double kHigh_m = 1.05;
  to.of(StreetMaterial::kMetal, kSteel, 0.45, 1);
  to.rod({x0, y, kTop_m + kHigh_m}, {x1, y, kTop_m + kHigh_m}, 0.022);
  to.rod({x0, y, kTop_m + 0.15}, {x1, y, kTop_m + 0.15}, 0.015);
  for (double x = x0; x < x1 + 0.01; x += 1.5) to.pole(x, y, kTop_m, kTop_m + kHigh_m, 0.028);
  for (double x = x0 + 0.15; x < x1; x += 0.15) to.pole(x, y, kTop_m + 0.15, kTop_m + kHigh_m, 0.009);
}

void add_sign_post(StreetSide& to, double x, double y) {
  const double high = to.between(2.3, 3.0);
  to.of(StreetMaterial::kMetal, kSteel, 0.45, 1).pole(x, y, kTop_m, kTop_m + high, 0.03);
  // The front faces the traffic on this side.
  const double face = to.side() < 0.0 ? -0.04 : 0.04;
  constexpr std::array<int, 5> kSides{0, 0, 3, 4, 8};
  double z = kTop_m + high - 0.3;
  for (int i = to.chance(0.4) ? 2 : 1; i > 0; --i) {
    const std::uint32_t kind = to.variety(5);
    const int sides = kSides[kind];
    const double radius = sides == 3 ? 0.20 : 0.30;
    to.of(StreetMaterial::kPlate, Vector3d::Ones(), 0.9, 1 + kind + 8 * to.variety(20));
    to.plate(x + face, y, z, radius, sides).tint.x() = face < 0.0 ? -1.0 : 1.0;
    z -= 0.72;
  }
}

void add_planter(StreetSide& to, double x, double y, double z) {
  to.of(StreetMaterial::kStone, {0.60, 0.58, 0.54}, 0.4).box(x - 0.5, x + 0.5, y - 0.3, y + 0.3, z, z + 0.45);
  const Vector3d leaf(to.between(0.16, 0.3), to.between(0.34, 0.5), 0.16);
  for (int i = 0; i < 16; ++i) {
    to.of(StreetMaterial::kLeaves, leaf * to.between(0.8, 1.25), 0.45)
        .ball(x + to.between(-0.42, 0.42),
              y + to.between(-0.24, 0.24),
              z + to.between(0.45, 0.85),
              to.between(0.08, 0.16));
  }
}

void add_bike_stands(StreetSide& to, double x, int count) {
  to.of(StreetMaterial::kMetal, kSteel, 0.5, 1);
  for (int i = 0; i < count; ++i) {
    const double at = x + 0.8 * i, y0 = kEdge_m - 0.05, y1 = kEdge_m + 0.55, z = kTop_m + 0.85;
    to.rod({at, y0, kTop_m}, {at, y0, z}, 0.024);
    to.rod({at, y0, z}, {at, y1, z}, 0.024);
    to.rod({at, y1, z}, {at, y1, kTop_m}, 0.024);
  }
}

void add_bench(StreetSide& to, double x) {
  const double y = kEdge_m + 0.35;
  to.of(StreetMaterial::kPainted, {0.44, 0.30, 0.18}, 0.35);
  for (int i = 0; i < 4; ++i) {
    to.box(x, x + 1.7, y + 0.13 * i - 0.25, y + 0.13 * i - 0.15, kTop_m + 0.42, kTop_m + 0.46);
  }
  for (int i = 0; i < 3; ++i) {
    to.box(x, x + 1.7, y + 0.26, y + 0.30, kTop_m + 0.55 + 0.14 * i, kTop_m + 0.64 + 0.14 * i);
  }
  to.of(StreetMaterial::kPainted, kDark, 0.3);
  for (const double end : {0.2, 1.45}) {
    to.box(x + end, x + end + 0.06, y - 0.22, y + 0.26, kTop_m, kTop_m + 0.42);
    to.box(x + end, x + end + 0.06, y + 0.22, y + 0.27, kTop_m + 0.4, kTop_m + 0.95);
  }
}

void add_shelter(StreetSide& to, double x) {
  const double y0 = kEdge_m + 0.05, y1 = kEdge_m + 1.25, high = 2.5;
  to.of(StreetMaterial::kMetal, kDark, 0.35, 1);
  for (const double along : {0.0, 1.3, 2.6, 3.9}) to.pole(x + along, y1, kTop_m, high, 0.035);
  for (const double along : {0.0, 3.9}) to.pole(x + along, y0 + 0.3, kTop_m, high, 0.035);
  to.of(StreetMaterial::kStone, {0.32, 0.34, 0.35}, 0.3)
      .box(x - 0.2, x + 4.1, y0, y1 + 0.1, high, high + 0.12);
  to.of(StreetMaterial::kPoster, kSteel, 0.4, 1 + to.variety(200))
      .box(x - 0.06, x + 0.06, y0 + 0.3, y1, kTop_m + 0.3, high - 0.3);
  to.of(StreetMaterial::kSlatted, {0.48, 0.34, 0.22}, 0.35)
      .box(x + 0.4, x + 3.4, y1 - 0.4, y1 - 0.05, kTop_m + 0.4, kTop_m + 0.48);
  to.of(StreetMaterial::kPoster, kSteel, 0.4, 1 + to.variety(200))
      .box(x + 2.65, x + 3.85, y1 - 0.02, y1 + 0.02, kTop_m + 0.7, high - 0.35);
}

/// Adds one object at x if it fits; returns its length.
double add_thing(StreetSide& to, double x, const StreetRoom& on_edge, const StreetRoom& behind) {
  const double kind = to.between(0.0, 1.0);
  const auto fits = [&](double length, bool is_deep) {
    return on_edge.is_free(x - 0.2, x + length + 0.2) &&
           (!is_deep || behind.is_free(x - 0.3, x + length + 0.3));
  };
  if (kind < 0.20) {
    const int count = 2 + static_cast<int>(to.variety(4));
    if (!fits(1.2 * count, false)) return 0.0;
    for (int i = 0; i < count; ++i) {
      to.of(StreetMaterial::kStriped, i % 2 == 0 ? kDark : Vector3d(0.30, 0.30, 0.31), 0.35, 1)
          .pole(x + 1.2 * i + 0.2, kEdge_m, kTop_m, kTop_m + 0.95, 0.06);
    }
    return 1.2 * count;
  }
  if (kind < 0.36) {
    const double length = 1.5 * (2 + to.variety(3));
    if (!fits(length, false)) return 0.0;
    add_railing(to, x, x + length, kEdge_m - 0.05);
    return length;
  }
  if (kind < 0.46) {
    if (!fits(0.5, false)) return 0.0;
    to.of(StreetMaterial::kSlatted, to.chance(0.5) ? kGreen : kDark, 0.3)
        .pole(x + 0.25, kEdge_m + 0.1, kTop_m, kTop_m + 0.85, 0.22);
    to.of(StreetMaterial::kPainted, {0.75, 0.45, 0.10}, 0.4)
        .pole(x + 0.25, kEdge_m + 0.1, kTop_m + 0.85, kTop_m + 0.93, 0.24);
    return 0.6;
  }
  if (kind < 0.60) {
    if (!fits(0.2, false)) return 0.0;
    add_sign_post(to, x + 0.1, kEdge_m - 0.02);
    return 0.3;
  }
  if (kind < 0.68) {
    if (!fits(1.2, true)) return 0.0;
    to.of(StreetMaterial::kPoster, {0.52, 0.55, 0.52}, 0.4, 1 + to.variety(200))
        .box(x, x + 1.1, kEdge_m, kEdge_m + 0.38, kTop_m, kTop_m + 1.25);
    return 1.3;
  }
  if (kind < 0.77) {
    if (!fits(1.0, true)) return 0.0;
    add_planter(to, x + 0.5, kEdge_m + 0.15, kTop_m);
    return 1.1;
  }
  if (kind < 0.86) {
    if (!fits(3.0, true)) return 0.0;
    add_bike_stands(to, x + 0.2, 2 + static_cast<int>(to.variety(3)));
    return 3.2;
  }
  if (kind < 0.92) {
    if (!fits(1.7, true)) return 0.0;
    add_bench(to, x);
    return 1.8;
  }
  if (kind < 0.95) {
    if (!fits(4.2, true)) return 0.0;
    add_shelter(to, x);
    return 4.4;
  }
  if (kind < 0.97) {
    if (!fits(1.2, true)) return 0.0;
    to.of(StreetMaterial::kPoster, kGreen, 0.4, 1 + to.variety(200))
        .pole(x + 0.6, kEdge_m + 0.7, kTop_m, kTop_m + 2.7, 0.55);
    return 1.3;
  }
  if (!fits(0.4, false)) return 0.0;
  to.of(StreetMaterial::kPainted, {0.70, 0.12, 0.10}, 0.4).pole(x + 0.2, kEdge_m, kTop_m, kTop_m + 0.6, 0.10);
  to.ball(x + 0.2, kEdge_m, kTop_m + 0.6, 0.10);
  return 0.5;
}

/// Extends the pavement between parked cars with enough space, with plants or bollards.
void add_build_outs(StreetSide& to, const StreetPlan& plan) {
  for (std::size_t i = 0; i + 1 < plan.cars.size(); ++i) {
    const double x0 = plan.cars[i].x() + 3.1, x1 = std::min(plan.cars[i + 1].x() - 3.1, x0 + 5.0);
    const bool is_ramp = std::any_of(plan.ramps.begin(), plan.ramps.end(), [&](double x) {
      return x > x0 - StreetPlan::kRampHalf_m && x < x1 + StreetPlan::kRampHalf_m;
    });
    if (x1 - x0 < 1.6 || is_ramp || !to.chance(0.75)) continue;
    constexpr std::uint32_t kKerbStyle = 2;
    const double out = 3.75, top = 0.13;
    to.of(StreetMaterial::kPavement, {0.66, 0.64, 0.60}, 0.35, kKerbStyle)
        .box(x0, x1, out, kRoadHalfWidth_m, -0.05, top);
    if (to.chance(0.5)) {
      add_detail_hedge(to, x0 + 0.3, x1 - 0.3, out + 0.45, out + 1.15, top, top + 0.65);
    } else {
      add_planter(to, 0.5 * (x0 + x1), out + 0.9, top);
    }
    for (const double x : {x0 + 0.25, x1 - 0.25}) {
      to.of(StreetMaterial::kStriped, {0.82, 0.12, 0.10}, 0.6, 3).pole(x, out + 0.25, top, top + 0.9, 0.06);
    }
  }
}

void add_lights(StreetSide& to, StreetRoom& room) {
  for (double start = kCrossingFirst_m - kCrossingEvery_m; start < kFurnitureEnd_m;
       start += kCrossingEvery_m) {
    const double x = to.side() < 0.0 ? start - 1.0 : start + kCrossingLong_m + 1.0;
    const double face = to.side() < 0.0 ? -1.0 : 1.0;
    room.take(x - 0.3, x + 0.3);
    to.of(StreetMaterial::kMetal, kDark, 0.35, 1).pole(x, kEdge_m, kTop_m, 5.4, 0.07);
    const auto head = [&](double y, double z) {
      to.of(StreetMaterial::kSignal, kDark, 0.3, face < 0.0 ? 1 : 2)
          .box(x + face * 0.08, x + face * 0.30, y - 0.16, y + 0.16, z, z + 0.95);
    };
    head(kEdge_m, 2.5);
    to.of(StreetMaterial::kMetal, kDark, 0.35, 1).rod({x, kEdge_m, 5.3}, {x, 1.9, 5.5}, 0.05);
    head(2.1, 4.6);
    to.of(StreetMaterial::kPoster, {0.85, 0.70, 0.12}, 0.5, 7)
        .box(x - 0.08, x + 0.08, kEdge_m - 0.16, kEdge_m - 0.07, 1.0, 1.25);
  }
}

}  // namespace

void add_detail_furniture(StreetSide& to, const StreetPlan& plan) {
  StreetRoom on_edge, behind;
  // Reserves the space of lamps and signs of the plain street.
  for (double x = -56.0; x < kFurnitureEnd_m; x += 24.0) on_edge.take(x - 0.2, x + 0.2);
  for (double x = 24.0; x < kFurnitureEnd_m; x += 56.0) on_edge.take(x - 0.3, x + 0.3);
  for (const double x : plan.ramps) on_edge.take(x - StreetPlan::kRampHalf_m, x + StreetPlan::kRampHalf_m);
  for (const StreetSolid& trunk : plan.trunks) behind.take(trunk.centre.x() - 0.6, trunk.centre.x() + 0.6);
  add_lights(to, on_edge);
  for (double x = kFurnitureStart_m; x < kFurnitureEnd_m; x += to.between(0.3, 1.8)) {
    x += add_thing(to, x, on_edge, behind);
  }
  add_build_outs(to, plan);
  if (to.side() < 0.0) return;
  for (double x = -40.0; x < kFurnitureEnd_m;
       x += to.between(18.0, 34.0)) {  // cables across the street, some with a lamp
    to.of(StreetMaterial::kPainted, {0.10, 0.10, 0.11}, 0.2).rod({x, -9.3, 6.7}, {x, 9.3, 6.7}, 0.02);
    if (!to.chance(0.6)) continue;
    to.of(StreetMaterial::kMetal, kSteel, 0.4, 1).box(x - 0.25, x + 0.25, -0.15, 0.15, 6.3, 6.55);
  }
}

}  // namespace simuli::bench

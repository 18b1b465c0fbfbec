// Relief of the detailed street's houses: sills, shutters, balconies, bay windows, shops, pipes, roofs.
#include <algorithm>
#include <array>
#include <cmath>

#include "bench/street/detail.hpp"

namespace simuli::bench {
namespace {

using Eigen::Vector3d;

constexpr double kStorey_m = 3.0, kCornice_m = 0.5;
constexpr double kWindowHalf_m = 0.68, kWindowFoot_m = 0.8, kWindowTop_m = 2.4;
const Vector3d kTrim(0.80, 0.78, 0.74), kIron(0.15, 0.16, 0.17), kZinc(0.50, 0.52, 0.54);

const std::array<Vector3d, 6> kShopTints{{{0.16, 0.34, 0.24},
                                          {0.62, 0.12, 0.12},
                                          {0.14, 0.20, 0.42},
                                          {0.82, 0.62, 0.16},
                                          {0.20, 0.20, 0.21},
                                          {0.70, 0.34, 0.50}}};

struct House {
  double x0, x1, front, height;
  StreetBays bays;
  int storeys;  // storeys with windows
  [[nodiscard]] double middle(int column) const { return x0 + (column + 0.5) * bays.width; }
  [[nodiscard]] int door() const { return bays.count / 2; }
};

void add_balcony(StreetSide& to, double x, double front, double floor, bool is_solid) {
  constexpr double kHalf_m = 0.95, kDeep_m = 0.85, kRail_m = 0.95, kBarEvery_m = 0.14, kBar_m = 0.010;
  const double y = front - kDeep_m;
  to.of(StreetMaterial::kStone, kTrim, 0.4).box(x - kHalf_m, x + kHalf_m, y, front, floor - 0.14, floor);
  if (is_solid) {
    to.of(StreetMaterial::kSlatted, to.dice().pick(kShopTints) * 0.5 + Vector3d::Constant(0.3), 0.35);
    to.box(x - kHalf_m, x + kHalf_m, y, y + 0.04, floor, floor + kRail_m);
    to.box(x - kHalf_m, x - kHalf_m + 0.04, y, front, floor, floor + kRail_m);
    to.box(x + kHalf_m - 0.04, x + kHalf_m, y, front, floor, floor + kRail_m);
    return;
  }
  to.of(StreetMaterial::kPainted, kIron, 0.3);
  const double top = floor + kRail_m;
  to.rod({x - kHalf_m, y + 0.03, top}, {x + kHalf_m, y + 0.03, top}, 0.02);
  for (double at = x - kHalf_m; at < x + kHalf_m + 0.01; at += kBarEvery_m) {
    to.pole(at, y + 0.03, floor, top, kBar_m);
  }
  for (const double end : {-kHalf_m, kHalf_m}) {
    to.rod({x + end, y + 0.03, top}, {x + end, front, top}, 0.02);
    for (double at = y + 0.03 + kBarEvery_m; at < front; at += kBarEvery_m) {
      to.pole(x + end, at, floor, top, kBar_m);
    }
  }
}

void add_flowers(StreetSide& to, double x, double front, double z) {
  to.of(StreetMaterial::kPainted, {0.42, 0.24, 0.16}, 0.3)
      .box(x - 0.5, x + 0.5, front - 0.24, front, z, z + 0.18);
  for (int i = 0; i < 7; ++i) {
    const bool is_flower = to.chance(0.4);
    const Vector3d tint = is_flower ? Vector3d(0.78, to.between(0.1, 0.6), 0.25) : Vector3d(0.22, 0.42, 0.16);
    to.of(StreetMaterial::kLeaves, tint, 0.45)
        .ball(x - 0.45 + 0.15 * i, front - 0.12 + to.between(-0.04, 0.04), z + 0.22, to.between(0.08, 0.13));
  }
}

void add_windows(StreetSide& to, const House& h, bool is_shop) {
  const bool has_shutters = to.chance(0.35), has_balconies = to.chance(0.55), has_bay = to.chance(0.3);
  const bool is_solid = to.chance(0.3);
  const Vector3d shutter = to.dice().pick(kShopTints) * 0.7 + Vector3d::Constant(0.12);
  const int bay_column = h.door() > 0 ? h.door() - 1 : h.bays.count - 1;
  for (int storey = is_shop ? 1 : 0; storey < h.storeys; ++storey) {
    for (int column = 0; column < h.bays.count; ++column) {
      if (storey == 0 && column == h.door()) continue;
      const double x = h.middle(column), floor = kStorey_m * storey;
      if (has_bay && column == bay_column && storey >= 1 && storey <= 2) {
        constexpr double kDeep_m = 0.6;
        const double y = h.front - kDeep_m;
        to.of(StreetMaterial::kBay, kTrim, 0.5)
            .box(x - 0.95, x + 0.95, y, h.front, floor + 0.2, floor + 2.85);
        if (storey == 1) {
          to.of(StreetMaterial::kStone, kTrim, 0.4)
              .cut(x - 0.95,
                   x + 0.95,
                   y,
                   h.front,
                   floor - 0.4,
                   floor + 0.2,
                   {0.0, -0.6, -0.6},
                   {x, y, floor + 0.2});
        }
        continue;
      }
      to.of(StreetMaterial::kStone, kTrim, 0.45)
          .box(x - 0.74,
               x + 0.74,
               h.front - 0.12,
               h.front,
               floor + kWindowFoot_m - 0.08,
               floor + kWindowFoot_m);
      to.box(x - 0.72, x + 0.72, h.front - 0.06, h.front, floor + kWindowTop_m, floor + kWindowTop_m + 0.16);
      const bool has_balcony = has_balconies && storey >= 1 && (column + storey) % 2 == 0;
      if (has_balcony) {
        add_balcony(to, x, h.front, floor + 0.1, is_solid);
      } else if (to.chance(0.18)) {
        add_flowers(to, x, h.front, floor + kWindowFoot_m);
      }
      if (has_shutters) {
        to.of(StreetMaterial::kSlatted, shutter, 0.3);
        for (const double end : {-1.0, 1.0}) {
          to.box(x + end * (kWindowHalf_m + 0.02),
                 x + end * std::min(kWindowHalf_m + 0.46, 0.5 * h.bays.width - 0.03),
                 h.front - 0.05,
                 h.front,
                 floor + kWindowFoot_m,
                 floor + kWindowTop_m);
        }
      } else if (storey >= 1 && to.chance(0.12)) {  // an air conditioner
        to.of(StreetMaterial::kSlatted, {0.78, 0.78, 0.76}, 0.4)
            .box(x + 0.75, x + 1.15, h.front - 0.32, h.front, floor + 0.5, floor + 1.0);
      }
    }
  }
}

void add_shop(StreetSide& to, const House& h) {
  const Vector3d tint = to.dice().pick(kShopTints);
  const double x0 = h.x0 + 0.35, x1 = h.x1 - 0.35;
  to.of(StreetMaterial::kLettering, tint, 0.4, 1 + to.variety(64))
      .box(x0, x1, h.front - 0.14, h.front, 2.72, 3.30);
  for (int column = 0; column < h.bays.count; ++column) {
    if (column == h.door() || !to.chance(0.65)) continue;
    const double x = h.middle(column), half = 0.5 * h.bays.width - 0.08, out = h.front - 1.15;
    const Vector3d stripe = to.chance(0.5) ? tint : Vector3d(0.75, 0.72, 0.62);
    to.of(StreetMaterial::kStriped, stripe, 0.4, 2)
        .cut(x - half, x + half, out, h.front, 2.22, 2.72, {0.0, -0.32, 1.15}, {x, h.front, 2.72});
  }
  if (to.chance(0.6)) {  // a sign across the pavement with its bracket
    const double x = to.chance(0.5) ? h.x0 + 0.5 : h.x1 - 0.5;
    to.of(StreetMaterial::kLettering, to.dice().pick(kShopTints), 0.5, 1 + to.variety(64))
        .box(x - 0.05, x + 0.05, h.front - 1.0, h.front - 0.2, 3.45, 4.15);
    to.of(StreetMaterial::kPainted, kIron, 0.3).rod({x, h.front, 4.2}, {x, h.front - 1.05, 4.2}, 0.02);
  }
  if (to.chance(0.5)) {  // a board on the pavement
    const double x = h.middle(h.door()) + 1.4;
    to.of(StreetMaterial::kPoster, kTrim, 0.4, 1 + to.variety(200))
        .box(x - 0.03, x + 0.03, h.front - 1.4, h.front - 0.8, kKerbHeight_m, 1.1);
  }
}

void add_roof(StreetSide& to, const House& h) {
  constexpr double kDeep_m = 6.0;
  const double top = h.height, ridge = top + to.between(1.8, 3.0);
  const Vector3d tiles = to.chance(0.6) ? Vector3d(0.52, 0.26, 0.20) : Vector3d(0.30, 0.31, 0.34);
  to.of(StreetMaterial::kRoof, tiles, 0.3)
      .cut(h.x0,
           h.x1,
           h.front - 0.2,
           h.front + kDeep_m,
           top,
           ridge,
           {0.0, top - ridge, kDeep_m},
           {h.x0, h.front, top});
  for (int column = 0; column < h.bays.count; ++column) {
    if (!to.chance(0.35)) continue;
    const double x = h.middle(column);
    to.of(StreetMaterial::kBay, kTrim, 0.45)
        .box(x - 0.7, x + 0.7, h.front + 0.7, h.front + 4.0, top, std::min(top + 1.5, ridge - 0.1));
  }
  const double chimney = to.between(h.x0 + 1.0, h.x1 - 1.0);
  to.of(StreetMaterial::kStone, {0.55, 0.32, 0.25}, 0.3, 2)
      .box(chimney - 0.35, chimney + 0.35, h.front + 2.5, h.front + 3.3, top, ridge + 0.7);
  for (const double y : {2.7, 3.05}) {
    to.of(StreetMaterial::kPainted, {0.50, 0.28, 0.20}, 0.3)
        .pole(chimney, h.front + y, ridge + 0.7, ridge + 1.1, 0.11);
  }
}

void add_front_garden(StreetSide& to, const House& h) {
  const double kind = to.between(0.0, 1.0);
  if (kind > 0.75) return;
  const double door = h.middle(h.door()), y = h.front - 0.75;
  for (const auto& [x0, x1] : {std::array{h.x0 + 0.4, door - 1.0}, std::array{door + 1.0, h.x1 - 0.4}}) {
    if (x1 - x0 < 1.0) continue;
    if (kind < 0.35) {
      add_detail_hedge(to, x0, x1, y, y + 0.5, kKerbHeight_m, kKerbHeight_m + to.between(0.6, 1.0));
      continue;
    }
    to.of(StreetMaterial::kStone, kTrim, 0.4).box(x0, x1, y, y + 0.2, kKerbHeight_m, 0.5);
    to.of(StreetMaterial::kPainted, kIron, 0.3);
    to.rod({x0, y + 0.1, 1.2}, {x1, y + 0.1, 1.2}, 0.02);
    for (double x = x0; x <= x1; x += 0.15) to.pole(x, y + 0.1, 0.5, 1.3, 0.011);
  }
}

}  // namespace

void add_detail_house(StreetSide& to, StreetSolid& house) {
  House h{};
  h.x0 = house.low.x();
  h.x1 = house.high.x();
  h.front = std::min(std::abs(house.low.y()), std::abs(house.high.y()));
  h.height = house.high.z();
  h.bays = street_bays(house);
  h.storeys = static_cast<int>(std::floor((h.height - 0.4) / kStorey_m));
  const bool is_shop = to.chance(0.45);
  constexpr std::uint32_t kWalls = 5;
  house.style = 1 + to.variety(kWalls) + (is_shop ? 8U : 0U) + 16U * to.variety(64);
  add_windows(to, h, is_shop);
  if (is_shop) {
    add_shop(to, h);
  } else {
    const double x = h.middle(h.door());
    to.of(StreetMaterial::kStone, {0.62, 0.60, 0.57}, 0.35);
    to.box(x - 0.85, x + 0.85, h.front - 0.65, h.front, 0.0, 0.30);
    to.box(x - 0.75, x + 0.75, h.front - 0.32, h.front, 0.30, 0.45);
    if (to.chance(0.5)) {
      to.of(StreetMaterial::kPainted, kZinc, 0.4).box(x - 0.8, x + 0.8, h.front - 0.7, h.front, 2.45, 2.55);
    }
    add_front_garden(to, h);
  }
  // String courses between storeys, the gutter, and the downpipe.
  to.of(StreetMaterial::kStone, kTrim, 0.45);
  for (int storey = 1; storey <= h.storeys; ++storey) {
    const double z = kStorey_m * storey;
    if (is_shop && storey == 1) continue;
    to.box(h.x0, h.x1, h.front - 0.07, h.front, z - 0.06, z + 0.10);
  }
  to.box(h.x0, h.x1, h.front - 0.28, h.front, h.height - kCornice_m, h.height - 0.28);
  to.of(StreetMaterial::kPainted, kZinc, 0.45);
  to.rod({h.x0 + 0.1, h.front - 0.3, h.height - 0.15}, {h.x1 - 0.1, h.front - 0.3, h.height - 0.15}, 0.08);
  const double pipe = to.chance(0.5) ? h.x0 + 0.16 : h.x1 - 0.16;
  to.pole(pipe, h.front - 0.12, kKerbHeight_m, h.height - kCornice_m, 0.05);
  for (int column = 0; column < h.bays.count; ++column) {  // lamps at the wall
    if (!to.chance(0.2)) continue;
    const double x = h.middle(column) + 0.5 * h.bays.width;
    if (x > h.x1 - 0.3) continue;
    to.of(StreetMaterial::kPainted, {0.92, 0.90, 0.78}, 0.5).ball(x, h.front - 0.16, 2.15, 0.12);
  }
  if (to.chance(0.7)) add_roof(to, h);
}

}  // namespace simuli::bench

// Construction of the synthetic street.
#include "io/synth/street_world.hpp"

#include <algorithm>
#include <array>

#include "io/synth/street.hpp"

namespace simuli {
namespace {

constexpr double kStreetStart_m = -60.0;
constexpr double kStreetEnd_m = Street::kLength_m + 80.0;  // there is always street ahead of the rig
constexpr double kFarAway_m = 1e4;

const std::array<Eigen::Vector3d, 7> kFacadeTints{{{0.72, 0.42, 0.32},
                                                   {0.80, 0.72, 0.55},
                                                   {0.62, 0.64, 0.66},
                                                   {0.78, 0.60, 0.40},
                                                   {0.55, 0.62, 0.56},
                                                   {0.84, 0.80, 0.74},
                                                   {0.60, 0.46, 0.42}}};
const std::array<Eigen::Vector3d, 6> kCarTints{{{0.70, 0.10, 0.10},
                                                {0.12, 0.24, 0.55},
                                                {0.85, 0.85, 0.85},
                                                {0.12, 0.12, 0.13},
                                                {0.55, 0.58, 0.60},
                                                {0.18, 0.42, 0.30}}};

StreetSolid pole(StreetMaterial material,
                 const Eigen::Vector3d& foot,
                 double height,
                 double radius,
                 const Eigen::Vector3d& tint,
                 double reflectance) {
  const Eigen::Vector3d arm(radius, radius, 0.0);
  return {meet_pole,
          material,
          foot - arm,
          foot + arm + Eigen::Vector3d(0.0, 0.0, height),
          foot,
          radius,
          tint,
          reflectance};
}

StreetSolid sphere(StreetMaterial material,
                   const Eigen::Vector3d& centre,
                   double radius,
                   const Eigen::Vector3d& tint,
                   double reflectance) {
  const Eigen::Vector3d arm = Eigen::Vector3d::Constant(radius);
  return {meet_sphere, material, centre - arm, centre + arm, centre, radius, tint, reflectance};
}

void add_signs(std::vector<StreetSolid>& to) {
  const Eigen::Vector3d steel(0.50, 0.51, 0.52);
  for (double x = 24.0; x < kStreetEnd_m; x += 56.0) {
    const Eigen::Vector3d foot(x, -5.85, kKerbHeight_m);
    to.push_back(pole(StreetMaterial::kMetal, foot, 2.2, 0.03, steel, 0.45));
    StreetSolid plate = street_box(StreetMaterial::kSign,
                                   foot + Eigen::Vector3d(-0.05, -0.4, 1.9),
                                   foot + Eigen::Vector3d(-0.03, 0.4, 2.7),
                                   {0.85, 0.10, 0.10},
                                   0.95);
    plate.centre = 0.5 * (plate.low + plate.high);
    to.push_back(plate);
  }
}

void add_thin_poles(std::vector<StreetSolid>& to, std::uint64_t seed) {
  StreetDice dice(~seed);  // random numbers independent of the rest of the street
  for (const double side : {-1.0, 1.0}) {
    for (double x = kStreetStart_m; x < kStreetEnd_m; x += 3.0) {
      const Eigen::Vector3d foot(x + dice.between(-0.5, 0.5), side * 5.7, kKerbHeight_m);
      to.push_back(
          pole(StreetMaterial::kMetal, foot, 2.5, dice.between(0.008, 0.02), {0.50, 0.51, 0.52}, 0.45));
    }
  }
}

}  // namespace

StreetSolid street_box(StreetMaterial material,
                       const Eigen::Vector3d& low,
                       const Eigen::Vector3d& high,
                       const Eigen::Vector3d& tint,
                       double reflectance) {
  return {meet_box, material, low, high, low, 0.0, tint, reflectance};
}

void add_street_car(std::vector<StreetSolid>& to, const Eigen::Vector3d& at, const Eigen::Vector3d& tint) {
  // Dark paint reflects little light, as on black cars, which LiDARs detect badly.
  const double paint = 0.04 + 0.6 * tint.mean();
  const auto part = [&](StreetMaterial material, double x0, double x1, double half_y, double z0, double z1) {
    StreetSolid solid = street_box(
        material, at + Eigen::Vector3d(x0, -half_y, z0), at + Eigen::Vector3d(x1, half_y, z1), tint, paint);
    solid.centre = at;
    to.push_back(solid);
  };
  part(StreetMaterial::kCarBody, -kCarHalfLength_m, kCarHalfLength_m, kCarHalfWidth_m, 0.26, 0.92);
  part(StreetMaterial::kCarCabin, -1.55, 0.95, 0.76, 0.92, kCarHeight_m);
  part(StreetMaterial::kTyre, -1.62, -0.98, 0.86, 0.0, 0.26);
  part(StreetMaterial::kTyre, 0.98, 1.62, 0.86, 0.0, 0.26);
}

void add_street_buildings(
    std::vector<StreetSolid>& to, StreetDice& dice, double side, double from_m, double to_m) {
  for (double x = from_m; x < to_m;) {
    const double width = dice.between(8.0, 15.0);
    const double height = dice.between(7.0, 15.0);
    const double front = kFacadeLine_m + dice.between(0.0, 0.8);
    const Eigen::Vector3d& tint = dice.pick(kFacadeTints);
    const double near_y = std::min(side * front, side * (front + 12.0));
    to.push_back(street_box(StreetMaterial::kFacade,
                            {x, near_y, 0.0},
                            {x + width, near_y + 12.0, height},
                            tint,
                            0.2 + 0.4 * tint.mean()));
    const bool alley = dice.between(0.0, 1.0) < 0.25;
    x += width + (alley ? dice.between(2.0, 4.0) : 0.0);
  }
}

void add_street_furniture(
    std::vector<StreetSolid>& to, StreetDice& dice, double side, double from_m, double to_m) {
  const Eigen::Vector3d steel(0.42, 0.44, 0.45);
  for (double x = from_m + 4.0; x < to_m; x += 24.0) {
    const Eigen::Vector3d foot(x, side * 5.95, kKerbHeight_m);
    to.push_back(pole(StreetMaterial::kMetal, foot, 5.2, dice.between(0.03, 0.05), steel, 0.45));
    const Eigen::Vector3d lamp = foot + Eigen::Vector3d(0.0, -side * 0.5, 5.2);
    to.push_back(street_box(StreetMaterial::kMetal,
                            lamp - Eigen::Vector3d(0.12, 0.6, 0.0),
                            lamp + Eigen::Vector3d(0.12, 0.6, 0.14),
                            steel,
                            0.35));
  }
  for (double x = from_m + 10.0; x < to_m; x += 12.0) {
    if (dice.between(0.0, 1.0) < 0.3) continue;
    const Eigen::Vector3d foot(x + dice.between(-1.5, 1.5), side * dice.between(6.4, 6.8), kKerbHeight_m);
    const double trunk = dice.between(2.2, 2.8);
    to.push_back(
        pole(StreetMaterial::kBark, foot, trunk + 0.4, dice.between(0.10, 0.18), {0.34, 0.26, 0.20}, 0.2));
    const Eigen::Vector3d leaf(dice.between(0.20, 0.32), dice.between(0.40, 0.50), dice.between(0.14, 0.22));
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector3d offset(dice.between(-0.7, 0.7), dice.between(-0.6, 0.6), 0.5 + 0.45 * i);
      to.push_back(sphere(StreetMaterial::kLeaves,
                          foot + offset + Eigen::Vector3d(0.0, 0.0, trunk),
                          dice.between(0.75, 1.2),
                          leaf,
                          0.45));
    }
  }
  for (double x = from_m + 6.0; x < to_m; x += dice.between(6.0, 11.0)) {
    if (dice.between(0.0, 1.0) < 0.25) continue;
    add_street_car(to, {x, side * dice.between(4.45, 4.6), 0.0}, dice.pick(kCarTints));
  }
}

StreetWorld build_street_world(const StreetContents& contents) {
  const std::uint64_t seed = contents.seed;
  StreetWorld world;
  world.seed = seed;
  StreetDice dice(seed);
  const double f = kFarAway_m;
  world.ground.push_back(
      street_box(StreetMaterial::kAsphalt, {-f, -f, -1.0}, {f, f, 0.0}, {0.33, 0.33, 0.34}, 0.16));
  for (const double side : {-1.0, 1.0}) {
    const double near_y = side > 0.0 ? kRoadHalfWidth_m : -f;
    const double far_y = side > 0.0 ? f : -kRoadHalfWidth_m;
    world.ground.push_back(street_box(
        StreetMaterial::kPavement, {-f, near_y, -1.0}, {f, far_y, kKerbHeight_m}, {0.58, 0.56, 0.53}, 0.3));
    add_street_buildings(world.solids, dice, side, kStreetStart_m, kStreetEnd_m);
    add_street_furniture(world.solids, dice, side, kStreetStart_m, kStreetEnd_m);
  }
  add_signs(world.solids);
  if (contents.thin_poles) add_thin_poles(world.solids, seed);
  // Houses close both ends: no ray leaves the street at eye height.
  for (const double x : {kStreetStart_m - 4.0, kStreetEnd_m}) {
    world.solids.push_back(street_box(
        StreetMaterial::kFacade, {x, -24.0, 0.0}, {x + 4.0, 24.0, 12.0}, dice.pick(kFacadeTints), 0.4));
  }
  // Patterns of boxes along the whole street start at the world's origin.
  for (StreetSolid& solid : world.ground) solid.centre.setZero();
  if (contents.car) add_street_car(world.car, Eigen::Vector3d::Zero(), {0.88, 0.62, 0.10});
  world.detail = contents.detail;
  if (world.detail != nullptr) world.detail->add(world);
  world.index = StreetIndex(world.solids);
  return world;
}

}  // namespace simuli

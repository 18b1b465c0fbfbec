// Generates the detailed synthetic street: helpers that add solids, the plan taken from the plain street,
// kerbs.
#include "bench/street/detail.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bench/street/detailed_street.hpp"
#include "io/synth/street.hpp"

namespace simuli::bench {
namespace {

using Eigen::Vector3d;

constexpr double kDetailStart_m = -64.0, kDetailEnd_m = Street::kLength_m + 84.0;
constexpr double kFirstLamp_m = -56.0, kLampEvery_m = 24.0, kFirstSign_m = 24.0, kSignEvery_m = 56.0;

double distance_to_row(double x, double first, double every) {
  const double past = x - first - every * std::floor((x - first) / every);
  return std::min(past, every - past);
}

/// Returns the positions of lowered kerbs: crossings, and driveways away from objects on the kerb.
std::vector<double> ramps_on(StreetSide& side, const std::vector<StreetSolid>& trunks) {
  std::vector<double> ramps;
  double driveway = kDetailStart_m + side.between(6.0, 14.0);
  for (double x = kCrossingFirst_m + 0.5 * kCrossingLong_m - 2.0 * kCrossingEvery_m; x < kDetailEnd_m;
       x += kCrossingEvery_m) {
    for (; driveway < x - 6.0; driveway += side.between(9.0, 26.0)) {
      constexpr double kClear_m = StreetPlan::kRampHalf_m + 0.25;
      const double at = driveway;
      const bool is_blocked = std::any_of(trunks.begin(), trunks.end(), [&](const StreetSolid& trunk) {
        return std::abs(trunk.centre.x() - at) < kClear_m;
      });
      if (is_blocked || distance_to_row(at, kFirstLamp_m, kLampEvery_m) < kClear_m ||
          distance_to_row(at, kFirstSign_m, kSignEvery_m) < kClear_m || at < kDetailStart_m + 4.0) {
        continue;
      }
      ramps.push_back(at);
    }
    driveway = std::max(driveway, x + 8.0);
    if (x > kDetailStart_m + 4.0 && x < kDetailEnd_m - 4.0) ramps.push_back(x);
  }
  return ramps;
}

/// Extracts the plan of one side from the solids of the plain street and removes replaced solids.
StreetPlan plan_of(std::vector<StreetSolid>& solids, double side) {
  StreetPlan plan;
  std::vector<StreetSolid> kept;
  for (StreetSolid& solid : solids) {
    const bool is_across = solid.low.y() < 0.0 && solid.high.y() > 0.0;
    if (is_across || solid.low.y() * side < 0.0) {
      kept.push_back(std::move(solid));
      continue;
    }
    switch (solid.material) {
      case StreetMaterial::kFacade:
        plan.houses.push_back(solid);
        break;
      case StreetMaterial::kBark:
        plan.trunks.push_back(solid);
        break;
      case StreetMaterial::kCarBody:
        plan.cars.push_back(solid.centre);
        break;
      case StreetMaterial::kCarCabin:
      case StreetMaterial::kTyre:
      case StreetMaterial::kLeaves:
        break;
      default:
        kept.push_back(std::move(solid));
    }
  }
  solids = std::move(kept);
  return plan;
}

}  // namespace

StreetSide& StreetSide::of(StreetMaterial material,
                           const Vector3d& tint,
                           double reflectance,
                           std::uint32_t style) {
  material_ = material;
  tint_ = tint;
  reflectance_ = reflectance;
  style_ = style;
  return *this;
}

StreetSolid& StreetSide::add(
    StreetShape* shape, const Vector3d& a, const Vector3d& b, const Vector3d& centre, double radius) {
  StreetSolid solid;
  solid.shape = shape;
  solid.material = material_;
  solid.low = a.cwiseMin(b);
  solid.high = a.cwiseMax(b);
  solid.centre = centre;
  solid.radius = radius;
  solid.tint = tint_;
  solid.reflectance = reflectance_;
  solid.style = style_;
  to_->push_back(solid);
  return to_->back();
}

StreetSolid& StreetSide::box(double x0, double x1, double y0, double y1, double z0, double z1) {
  const Vector3d a = placed(x0, y0, z0), b = placed(x1, y1, z1);
  return add(meet_box, a, b, a.cwiseMin(b), 0.0);
}

StreetSolid& StreetSide::cut(double x0,
                             double x1,
                             double y0,
                             double y1,
                             double z0,
                             double z1,
                             const Vector3d& axis,
                             const Vector3d& through) {
  StreetSolid& solid = box(x0, x1, y0, y1, z0, z1);
  solid.shape = meet_cut;
  solid.axis = placed(axis.x(), axis.y(), axis.z()).normalized();
  solid.radius = solid.axis.dot(placed(through.x(), through.y(), through.z()));
  return solid;
}

StreetSolid& StreetSide::pole(double x, double y, double z0, double z1, double radius) {
  const Vector3d foot = placed(x, y, z0), arm(radius, radius, 0.0);
  return add(meet_pole, foot - arm, foot + arm + Vector3d(0.0, 0.0, z1 - z0), foot, radius);
}

StreetSolid& StreetSide::rod(const Vector3d& from, const Vector3d& to, double radius) {
  const Vector3d a = placed(from.x(), from.y(), from.z()), b = placed(to.x(), to.y(), to.z());
  const Vector3d arm = Vector3d::Constant(radius);
  StreetSolid& solid = add(meet_rod, a.cwiseMin(b) - arm, a.cwiseMax(b) + arm, a, radius);
  solid.axis = b - a;
  return solid;
}

StreetSolid& StreetSide::ball(double x, double y, double z, double radius) {
  const Vector3d centre = placed(x, y, z), arm = Vector3d::Constant(radius);
  return add(meet_sphere, centre - arm, centre + arm, centre, radius);
}

StreetSolid& StreetSide::plate(double x, double y, double z, double radius, int sides) {
  const double reach = sides == 3 ? 2.0 : 1.5;  // circumradius factor of a triangle and of a square
  const Vector3d centre = placed(x, y, z), arm(0.0, reach * radius, reach * radius);
  StreetSolid& solid = add(meet_plate, centre - arm, centre + arm, centre, radius);
  solid.axis.x() = sides;
  return solid;
}

bool StreetRoom::is_free(double from_m, double to_m) const {
  return std::none_of(taken_.begin(), taken_.end(), [&](const Eigen::Vector2d& taken) {
    return from_m < taken.y() && to_m > taken.x();
  });
}

void add_detail_kerbs(StreetSide& to, const StreetPlan& plan) {
  constexpr double kLow_m = 0.03, kSlope_m = 0.5, kHalf_m = StreetPlan::kRampHalf_m;
  constexpr double kUnder_m = -0.05;
  constexpr std::uint32_t kKerbStyle = 2;
  const Vector3d stone(0.70, 0.69, 0.66), slab(0.58, 0.56, 0.53);
  const auto run = [&](double x0, double x1) {
    to.of(StreetMaterial::kPavement, stone, 0.35, kKerbStyle)
        .box(x0, x1, kRoadHalfWidth_m, kKerbBack_m, kUnder_m, kKerbHeight_m);
    to.of(StreetMaterial::kPavement, slab, 0.3)
        .box(x0, x1, kKerbBack_m, kRampBack_m, kUnder_m, kKerbHeight_m);
  };
  double from = kDetailStart_m;
  for (const double x : plan.ramps) {
    run(from, x - kHalf_m);
    from = x + kHalf_m;
    const double flat = kHalf_m - kSlope_m, rise = kKerbHeight_m - kLow_m;
    for (const double end : {-1.0, 1.0}) {
      const double x0 = x + end * flat, x1 = x + end * kHalf_m;
      to.of(StreetMaterial::kPavement, stone, 0.35, kKerbStyle)
          .cut(x0,
               x1,
               kRoadHalfWidth_m,
               kKerbBack_m,
               kUnder_m,
               kKerbHeight_m,
               {-end * rise, 0.0, kSlope_m},
               {x0, kRoadHalfWidth_m, kLow_m});
      to.of(StreetMaterial::kPavement, slab, 0.3)
          .box(x0, x1, kKerbBack_m, kRampBack_m, kUnder_m, kKerbHeight_m);
    }
    to.of(StreetMaterial::kPavement, stone, 0.35, kKerbStyle)
        .box(x - flat, x + flat, kRoadHalfWidth_m, kKerbBack_m, kUnder_m, kLow_m);
    constexpr std::uint32_t kTactile = 3;
    const bool is_crossing =
        distance_to_row(x, kCrossingFirst_m + 0.5 * kCrossingLong_m, kCrossingEvery_m) < 0.1;
    to.of(StreetMaterial::kPavement, slab, 0.3, is_crossing ? kTactile : 1)
        .cut(x - flat,
             x + flat,
             kKerbBack_m,
             kRampBack_m,
             kUnder_m,
             kKerbHeight_m,
             {0.0, -rise, kRampBack_m - kKerbBack_m},
             {x, kKerbBack_m, kLow_m});
  }
  run(from, kDetailEnd_m);
}

namespace {

void add_detail(StreetWorld& world) {
  for (StreetSolid& solid : world.ground) {
    solid.style = 1;
    if (solid.material != StreetMaterial::kPavement) continue;
    if (solid.low.y() > 0.0) solid.low.y() = kRampBack_m;
    if (solid.low.y() < 0.0) solid.high.y() = -kRampBack_m;
  }
  for (StreetSolid& solid : world.car) solid.style = 1;
  for (StreetSolid& solid : world.solids) {
    if (solid.material == StreetMaterial::kFacade) solid.style = 1;
  }
  std::vector<StreetSolid> added;
  for (const double sign : {-1.0, 1.0}) {
    StreetPlan plan = plan_of(world.solids, sign);
    // Separate random numbers per kind of object: one more object of a kind changes no other kind.
    const auto side = [&](std::uint64_t kind) {
      return StreetSide(added, sign, (world.seed * 64 + kind) * 2 + (sign > 0.0 ? 1 : 0) + 0x7f4a7c15ULL);
    };
    StreetSide kerbs = side(1), houses = side(2), trees = side(3), vehicles = side(4), furniture = side(5);
    plan.ramps = ramps_on(kerbs, plan.trunks);
    add_detail_kerbs(kerbs, plan);
    for (StreetSolid& house : plan.houses) add_detail_house(houses, house);
    for (const StreetSolid& trunk : plan.trunks) add_detail_tree(trees, trunk);
    for (const Vector3d& at : plan.cars) {
      // `bench --shift` moves the rig 3 m to the right, over the roofs of parked cars: inside a van the rig
      // would see no valid view.
      constexpr double kFirst_m = -4.0, kLast_m = 30.0;
      const bool is_low = sign < 0.0 && at.x() > kFirst_m && at.x() < kLast_m;
      add_detail_vehicle(vehicles, at, is_low);
    }
    add_detail_furniture(furniture, plan);
    for (std::vector<StreetSolid>* kept : {&plan.houses, &plan.trunks}) {
      for (StreetSolid& solid : *kept) solid.style = std::max(solid.style, 1U);
      world.solids.insert(world.solids.end(), kept->begin(), kept->end());
    }
  }
  world.solids.insert(world.solids.end(), added.begin(), added.end());
}

}  // namespace

const StreetDetail& detailed_street() {
  static constexpr StreetDetail kDetail{.add = add_detail, .surface = detail_surface};
  return kDetail;
}

}  // namespace simuli::bench

#pragma once
// Inside the detailed synthetic street: what stands there beside the plain one's houses, lamps and trunks,
// and what it looks like.
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "io/synth/street_world.hpp"

namespace simuli::bench {

// What is where across the street, m from its middle. Nothing higher than paint stands within 3.4 m: there
// the rig drives, in its lane and beside it.
inline constexpr double kKerbBack_m = 5.75;       // kerb stones end
inline constexpr double kRampBack_m = 6.15;       // lowered pavement ends
inline constexpr double kCrossingFirst_m = 36.0;  // x of the zebra crossings, one every kCrossingEvery_m
inline constexpr double kCrossingEvery_m = 80.0;
inline constexpr double kCrossingLong_m = 3.0;

/// All within radius of the line from centre to centre + axis.
StreetShape meet_rod;
/// What of the box has axis . p <= radius (m, world), axis of length 1.
StreetShape meet_cut;
/// Its face towards the ray: no thickness, across x, with axis.x() sides of which each is `radius` from its middle,
/// one of them below; no sides: round.
StreetShape meet_plate;

/// Adds solids on one side of the street. y is counted from the road's middle outwards, so that both sides
/// are written alike.
class StreetSide {
 public:
  StreetSide(std::vector<StreetSolid>& to, double side, std::uint64_t seed)
      : to_(&to), side_(side), dice_(seed) {}

  /// What the next solids are of.
  StreetSide& of(StreetMaterial material,
                 const Eigen::Vector3d& tint,
                 double reflectance,
                 std::uint32_t style = 1);
  StreetSolid& box(double x0, double x1, double y0, double y1, double z0, double z1);
  /// Of which axis . p <= offset is left; axis as counted on this side, of any length.
  StreetSolid& cut(double x0,
                   double x1,
                   double y0,
                   double y1,
                   double z0,
                   double z1,
                   const Eigen::Vector3d& axis,
                   const Eigen::Vector3d& through);
  StreetSolid& pole(double x, double y, double z0, double z1, double radius);
  StreetSolid& rod(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius);
  StreetSolid& ball(double x, double y, double z, double radius);
  StreetSolid& plate(double x, double y, double z, double radius, int sides);

  [[nodiscard]] double side() const { return side_; }
  StreetDice& dice() { return dice_; }
  double between(double low, double high) { return dice_.between(low, high); }
  bool chance(double share) { return dice_.between(0.0, 1.0) < share; }
  std::uint32_t variety(std::uint32_t kinds) {
    return static_cast<std::uint32_t>(dice_.between(0.0, static_cast<double>(kinds)));
  }

 private:
  [[nodiscard]] Eigen::Vector3d placed(double x, double y, double z) const { return {x, side_ * y, z}; }
  StreetSolid& add(StreetShape* shape,
                   const Eigen::Vector3d& a,
                   const Eigen::Vector3d& b,
                   const Eigen::Vector3d& centre,
                   double radius);

  std::vector<StreetSolid>* to_;
  double side_;
  StreetDice dice_;
  StreetMaterial material_ = StreetMaterial::kPainted;
  Eigen::Vector3d tint_ = Eigen::Vector3d::Ones();
  double reflectance_ = 0.0;
  std::uint32_t style_ = 1;
};

/// Stretches along x that are taken already.
class StreetRoom {
 public:
  void take(double from_m, double to_m) { taken_.push_back({from_m, to_m}); }
  [[nodiscard]] bool is_free(double from_m, double to_m) const;

 private:
  std::vector<Eigen::Vector2d> taken_;
};

/// What is needed of the plain street to build the detailed one.
struct StreetPlan {
  std::vector<StreetSolid> houses;            // of one side
  std::vector<StreetSolid> trunks;            // of one side
  std::vector<Eigen::Vector3d> cars;          // where parked cars stand, on one side
  std::vector<double> ramps;                  // x of the middles of lowered kerbs
  static constexpr double kRampHalf_m = 1.7;  // half of what is lowered
};

void add_detail_kerbs(StreetSide& to, const StreetPlan& plan);
void add_detail_tree(StreetSide& to, const StreetSolid& trunk);
/// A low wall of leaves.
void add_detail_hedge(StreetSide& to, double x0, double x1, double y0, double y1, double z0, double z1);
/// A vehicle in the place of a parked car. Low: none is higher than a car.
void add_detail_vehicle(StreetSide& to, const Eigen::Vector3d& at, bool is_low);
void add_detail_house(StreetSide& to, StreetSolid& house);
/// What stands along the pavement's edge.
void add_detail_furniture(StreetSide& to, const StreetPlan& plan);

/// StreetDetail::surface.
[[nodiscard]] StreetSurface detail_surface(const StreetSolid& solid,
                                           const Eigen::Vector3d& point,
                                           const Eigen::Vector3d& normal,
                                           std::uint64_t seed,
                                           double footprint_m);
[[nodiscard]] StreetSurface detail_road(const StreetSolid& solid,
                                        const Eigen::Vector3d& point,
                                        std::uint64_t seed,
                                        double footprint_m);
[[nodiscard]] StreetSurface detail_pavement(const StreetSolid& solid,
                                            const Eigen::Vector3d& point,
                                            const Eigen::Vector3d& normal,
                                            std::uint64_t seed,
                                            double footprint_m);
[[nodiscard]] StreetSurface detail_facade(const StreetSolid& solid,
                                          const Eigen::Vector3d& point,
                                          const Eigen::Vector3d& normal,
                                          std::uint64_t seed,
                                          double footprint_m);
/// Of vehicles: bodies, cabins, number plates.
[[nodiscard]] StreetSurface detail_vehicle(const StreetSolid& solid,
                                           const Eigen::Vector3d& point,
                                           const Eigen::Vector3d& normal,
                                           std::uint64_t seed,
                                           double footprint_m);

}  // namespace simuli::bench

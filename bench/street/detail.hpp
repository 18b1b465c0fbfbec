#pragma once
// Internals of the detailed synthetic street: its additional objects and their appearance.
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "io/synth/street_world.hpp"

namespace simuli::bench {

// Positions across the street, m from its middle. No object is within 3.4 m, where the rig drives.
inline constexpr double kKerbBack_m = 5.75;       // end of kerb stones
inline constexpr double kRampBack_m = 6.15;       // end of lowered pavement
inline constexpr double kCrossingFirst_m = 36.0;  // x of the first zebra crossing; spacing kCrossingEvery_m
inline constexpr double kCrossingEvery_m = 80.0;
inline constexpr double kCrossingLong_m = 3.0;

/// All points within radius of the line from centre to centre + axis.
StreetShape meet_rod;
/// The part of the box with axis . p <= radius (m, world), for a unit axis.
StreetShape meet_cut;
/// A plate across x that faces the ray, without thickness: a regular polygon with axis.x() sides at distance
/// `radius` from its centre, one of them at the bottom; 0 sides: a disc.
StreetShape meet_plate;

/// Adds solids on one side of the street. y is measured from the road's middle outwards, for both sides.
class StreetSide {
 public:
  StreetSide(std::vector<StreetSolid>& to, double side, std::uint64_t seed)
      : to_(&to), side_(side), dice_(seed) {}

  /// Sets the material of the next solids.
  StreetSide& of(StreetMaterial material,
                 const Eigen::Vector3d& tint,
                 double reflectance,
                 std::uint32_t style = 1);
  StreetSolid& box(double x0, double x1, double y0, double y1, double z0, double z1);
  /// Adds the part of a box with axis . p <= offset; axis in the coordinates of this side, of any length.
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

/// Occupied intervals along x.
class StreetRoom {
 public:
  void take(double from_m, double to_m) { taken_.push_back({from_m, to_m}); }
  [[nodiscard]] bool is_free(double from_m, double to_m) const;

 private:
  std::vector<Eigen::Vector2d> taken_;
};

/// Parts of the plain street that the detailed street needs.
struct StreetPlan {
  std::vector<StreetSolid> houses;            // on one side
  std::vector<StreetSolid> trunks;            // on one side
  std::vector<Eigen::Vector3d> cars;          // positions of parked cars on one side
  std::vector<double> ramps;                  // x of the centres of lowered kerbs
  static constexpr double kRampHalf_m = 1.7;  // half length of a lowered kerb
};

void add_detail_kerbs(StreetSide& to, const StreetPlan& plan);
void add_detail_tree(StreetSide& to, const StreetSolid& trunk);
/// Adds a hedge.
void add_detail_hedge(StreetSide& to, double x0, double x1, double y0, double y1, double z0, double z1);
/// Adds a vehicle in place of a parked car. Low: not higher than a car.
void add_detail_vehicle(StreetSide& to, const Eigen::Vector3d& at, bool is_low);
void add_detail_house(StreetSide& to, StreetSolid& house);
/// Adds objects along the pavement's edge.
void add_detail_furniture(StreetSide& to, const StreetPlan& plan);

/// Implements StreetDetail::surface.
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
/// Surface of vehicles: bodies, cabins, number plates.
[[nodiscard]] StreetSurface detail_vehicle(const StreetSolid& solid,
                                           const Eigen::Vector3d& point,
                                           const Eigen::Vector3d& normal,
                                           std::uint64_t seed,
                                           double footprint_m);

}  // namespace simuli::bench

#pragma once
// Inside the synthetic street: its solids and what they are made of. Included by io/street_*.cpp alone.
#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

namespace simuli {

/// What a surface looks like; the patterns are in io/synth/street_material.cpp.
enum class StreetMaterial {
  kAsphalt,
  kPavement,
  kFacade,
  kCarBody,
  kCarCabin,
  kTyre,
  kMetal,
  kSign,
  kBark,
  kLeaves
};

enum class StreetShape { kBox, kPole, kSphere };

/// One solid. Box: low and high corners. Pole (vertical cylinder): axis through centre from low.z to high.z.
/// Sphere: centre and radius. `centre` is also where the patterns start.
struct StreetSolid {
  StreetShape shape = StreetShape::kBox;
  StreetMaterial material = StreetMaterial::kAsphalt;
  Eigen::Vector3d low = Eigen::Vector3d::Zero();     // m, bounds in any shape
  Eigen::Vector3d high = Eigen::Vector3d::Zero();    // m
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // m
  double radius = 0.0;                               // m
  Eigen::Vector3d tint = Eigen::Vector3d::Ones();    // base colour
  double reflectance = 0.0;                          // base, [0,1]
};

struct StreetSurface {
  Eigen::Vector3d albedo = Eigen::Vector3d::Zero();
  double reflectance = 0.0;
};

/// Distance along a ray and the normal there.
struct StreetCrossing {
  double range = std::numeric_limits<double>::infinity();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
};

/// All solids that stand still, sorted into slices of the street along x, and the moving car in its own frame
/// (origin under its middle, x forward).
struct StreetWorld {
  std::uint64_t seed = 0;
  std::vector<StreetSolid> ground;  // as long as the street: tested for every ray
  std::vector<StreetSolid> solids;
  std::vector<std::vector<std::uint32_t>> slices;  // indices into solids
  std::vector<StreetSolid> car;                    // empty: no moving car

  static constexpr double kSliceLength_m = 8.0;
  static constexpr double kFirstSlice_m = -64.0;
};

inline constexpr double kRoadHalfWidth_m = 5.5;  // two driving lanes and two parking lanes
inline constexpr double kLaneEdge_m = 3.5;       // edge line between driving and parking lane
inline constexpr double kKerbHeight_m = 0.15;
inline constexpr double kFacadeLine_m = 9.0;
inline constexpr double kCarHalfLength_m = 2.1;
inline constexpr double kCarHalfWidth_m = 0.88;
inline constexpr double kCarHeight_m = 1.48;

[[nodiscard]] StreetWorld build_street_world(std::uint64_t seed, bool moving_car, bool thin_poles);
/// Colour and reflectance of `solid` at `point` (in the solid's frame, on the surface with that normal).
[[nodiscard]] StreetSurface street_surface(const StreetSolid& solid,
                                           const Eigen::Vector3d& point,
                                           const Eigen::Vector3d& normal,
                                           std::uint64_t seed);
[[nodiscard]] Eigen::Vector3d street_sky(const Eigen::Vector3d& direction);

}  // namespace simuli

#pragma once
// Solids and materials of the synthetic street, for io/synth/*.cpp and their tests.
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

namespace simuli {

struct StreetContents;

/// Material of a surface; the patterns are in io/synth/street_material.cpp.
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
  kLeaves,
  // Materials of a detail (bench/street), which defines their patterns.
  kStone,
  kPainted,
  kStriped,
  kSlatted,
  kPoster,
  kPlate,
  kSignal,
  kLettering,
  kRoof,
  kBay,
  kShade,
  kVan,
  kNumberPlate
};

/// Distance along a ray and the normal there.
struct StreetCrossing {
  double range = std::numeric_limits<double>::infinity();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
};

struct StreetSolid;
/// Updates `nearest` and returns true if the ray intersects a solid of that shape before it. Details
/// (bench/street) define further shapes.
using StreetShape = bool(const StreetSolid& solid,
                         const Eigen::Vector3d& origin,
                         const Eigen::Vector3d& direction,
                         const Eigen::Vector3d& inverse,
                         StreetCrossing& nearest);
/// Box between low and high corners; rays that start inside do not intersect.
StreetShape meet_box;
/// Vertical cylinder with axis through centre from low.z to high.z, standing on the ground.
StreetShape meet_pole;
/// Sphere with centre and radius.
StreetShape meet_sphere;
/// Closer hits are the surface on which the ray starts.
inline constexpr double kNearestHit_m = 1e-9;

/// One solid. `centre` is also the origin of its patterns.
struct StreetSolid {
  StreetShape* shape = meet_box;
  StreetMaterial material = StreetMaterial::kAsphalt;
  Eigen::Vector3d low = Eigen::Vector3d::Zero();     // m, bounds of any shape
  Eigen::Vector3d high = Eigen::Vector3d::Zero();    // m
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // m
  double radius = 0.0;                               // m
  Eigen::Vector3d tint = Eigen::Vector3d::Ones();    // base colour
  double reflectance = 0.0;                          // base, [0,1]
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();    // depends on the shape
  std::uint32_t style = 0;                           // 0: plain; else the variant of a detail's material
};

struct StreetSurface {
  Eigen::Vector3d albedo = Eigen::Vector3d::Zero();
  double reflectance = 0.0;
};

/// A bounding-box tree over solids: a ray tests only solids whose boxes it intersects.
class StreetIndex {
 public:
  explicit StreetIndex(const std::vector<StreetSolid>& solids);
  /// Tests the indexed solids as their shapes do.
  [[nodiscard]] const StreetSolid* meet(const std::vector<StreetSolid>& solids,
                                        const Eigen::Vector3d& origin,
                                        const Eigen::Vector3d& direction,
                                        const Eigen::Vector3d& inverse,
                                        StreetCrossing& nearest) const;

 private:
  struct Node {
    Eigen::Vector3d low, high;
    std::uint32_t first = 0;  // leaf: index of its first solid in order_; else node of the second child
    std::uint32_t count = 0;  // leaf: number of solids; 0: two children, the first one follows
    int axis = 0;             // split axis
  };
  void part(const std::vector<StreetSolid>& solids, std::uint32_t first, std::uint32_t count);

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;
};

struct StreetWorld;

/// Callbacks that add detail to a plain street.
struct StreetDetail {
  /// Adds and changes solids; solids with other than plain materials get a style.
  void (*add)(StreetWorld& world);
  /// As street_surface(), for solids with a style. Patterns finer than footprint_m, the width of a pixel there,
  /// are averaged.
  StreetSurface (*surface)(const StreetSolid& solid,
                           const Eigen::Vector3d& point,
                           const Eigen::Vector3d& normal,
                           std::uint64_t seed,
                           double footprint_m);
};

/// All static solids, and the moving car in its own frame (origin below its centre, x forward).
struct StreetWorld {
  std::uint64_t seed = 0;
  std::vector<StreetSolid> ground;  // as long as the street: tested for every ray
  std::vector<StreetSolid> solids;
  StreetIndex index{{}};         // of `solids`
  std::vector<StreetSolid> car;  // empty: no moving car
  const StreetDetail* detail = nullptr;
};

inline constexpr double kRoadHalfWidth_m = 5.5;  // two driving lanes and two parking lanes
inline constexpr double kLaneEdge_m = 3.5;       // edge line between driving and parking lane
inline constexpr double kKerbHeight_m = 0.15;
inline constexpr double kFacadeLine_m = 9.0;
inline constexpr double kCarHalfLength_m = 2.1;
inline constexpr double kCarHalfWidth_m = 0.88;
inline constexpr double kCarHeight_m = 1.48;

/// Uniform numbers from the engine's bits, because standard distributions differ between libraries.
class StreetDice {
 public:
  explicit StreetDice(std::uint64_t seed) : engine_(seed) {}
  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11U) * 0x1.0p-53;
  }
  template <std::size_t N>
  const Eigen::Vector3d& pick(const std::array<Eigen::Vector3d, N>& from) {
    return from[static_cast<std::size_t>(engine_() % N)];
  }

 private:
  std::mt19937_64 engine_;
};

// Parts of a street along x, at positive or negative y by `side` (1 or -1).
[[nodiscard]] StreetSolid street_box(StreetMaterial material,
                                     const Eigen::Vector3d& low,
                                     const Eigen::Vector3d& high,
                                     const Eigen::Vector3d& tint,
                                     double reflectance);
/// Adds houses from x = from_m; the last one begins before to_m.
void add_street_buildings(
    std::vector<StreetSolid>& to, StreetDice& dice, double side, double from_m, double to_m);
/// Adds lamps, trees and parked cars.
void add_street_furniture(
    std::vector<StreetSolid>& to, StreetDice& dice, double side, double from_m, double to_m);
/// Adds a car with its centre on the road at `at`, aligned with the x axis.
void add_street_car(std::vector<StreetSolid>& to, const Eigen::Vector3d& at, const Eigen::Vector3d& tint);

/// Returns sun and sky light, constant and without cast shadows, so that appearance depends on the surface
/// only.
[[nodiscard]] double street_light(const Eigen::Vector3d& normal);

/// Number and width in m of the bays of windows, doors and shops of a house.
struct StreetBays {
  int count = 1;
  double width = 0.0;
};
[[nodiscard]] StreetBays street_bays(const StreetSolid& house);
/// Whether the plain street has paint at this position of the road.
[[nodiscard]] bool street_lane_marking(double x, double y);

[[nodiscard]] StreetWorld build_street_world(const StreetContents& contents);
/// Returns colour and reflectance of `solid`, without a style, at `point` (in the solid's frame, on the surface
/// with that normal). No pattern is finer than a pixel.
[[nodiscard]] StreetSurface street_surface(const StreetSolid& solid,
                                           const Eigen::Vector3d& point,
                                           const Eigen::Vector3d& normal,
                                           std::uint64_t seed);
[[nodiscard]] Eigen::Vector3d street_sky(const Eigen::Vector3d& direction);

}  // namespace simuli

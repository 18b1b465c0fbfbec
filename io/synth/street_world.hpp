#pragma once
// Inside the synthetic street: its solids and what they are made of. Included by io/synth/*.cpp and their
// tests alone.
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

namespace simuli {

struct StreetContents;

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
  kLeaves,
  // Of a detail alone (bench/street), whose patterns they are.
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
/// The crossing with a solid of that shape becomes `nearest` where it is nearer, and the result true. Details
/// (bench/street) have shapes of their own.
using StreetShape = bool(const StreetSolid& solid,
                         const Eigen::Vector3d& origin,
                         const Eigen::Vector3d& direction,
                         const Eigen::Vector3d& inverse,
                         StreetCrossing& nearest);
/// Low and high corners; a ray from inside meets nothing.
StreetShape meet_box;
/// A vertical cylinder: axis through centre from low.z to high.z, its foot on the ground.
StreetShape meet_pole;
/// Centre and radius.
StreetShape meet_sphere;
/// Hits nearer than this are the surface the ray starts on.
inline constexpr double kNearestHit_m = 1e-9;

/// One solid. `centre` is also where the patterns start.
struct StreetSolid {
  StreetShape* shape = meet_box;
  StreetMaterial material = StreetMaterial::kAsphalt;
  Eigen::Vector3d low = Eigen::Vector3d::Zero();     // m, bounds in any shape
  Eigen::Vector3d high = Eigen::Vector3d::Zero();    // m
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // m
  double radius = 0.0;                               // m
  Eigen::Vector3d tint = Eigen::Vector3d::Ones();    // base colour
  double reflectance = 0.0;                          // base, [0,1]
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();    // as the shape has it
  std::uint32_t style = 0;                           // 0: plain; else which variety of a detail's material
};

struct StreetSurface {
  Eigen::Vector3d albedo = Eigen::Vector3d::Zero();
  double reflectance = 0.0;
};

/// A tree of bounding boxes over solids: a ray tests those alone whose boxes it crosses.
class StreetIndex {
 public:
  explicit StreetIndex(const std::vector<StreetSolid>& solids);
  /// As the shape of each of the solids that the index was made of.
  [[nodiscard]] const StreetSolid* meet(const std::vector<StreetSolid>& solids,
                                        const Eigen::Vector3d& origin,
                                        const Eigen::Vector3d& direction,
                                        const Eigen::Vector3d& inverse,
                                        StreetCrossing& nearest) const;

 private:
  struct Node {
    Eigen::Vector3d low, high;
    std::uint32_t first = 0;  // of a leaf: its solids' place in order_; else the second child's node
    std::uint32_t count = 0;  // of a leaf's solids; 0: two children, the first one right behind
    int axis = 0;             // along which children are parted
  };
  void part(const std::vector<StreetSolid>& solids, std::uint32_t first, std::uint32_t count);

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;
};

struct StreetWorld;

/// What makes a plain street a richer one.
struct StreetDetail {
  /// Adds and changes solids; those that are not of plain materials get a style.
  void (*add)(StreetWorld& world);
  /// As street_surface(), for solids with a style. Patterns finer than footprint_m, the width of a pixel
  /// there, show as their mean.
  StreetSurface (*surface)(const StreetSolid& solid,
                           const Eigen::Vector3d& point,
                           const Eigen::Vector3d& normal,
                           std::uint64_t seed,
                           double footprint_m);
};

/// All solids that stand still, and the moving car in its own frame (origin under its middle, x forward).
struct StreetWorld {
  std::uint64_t seed = 0;
  std::vector<StreetSolid> ground;  // as long as the street: tested for every ray
  std::vector<StreetSolid> solids;
  StreetIndex index{{}};         // of them
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

/// Uniform numbers from the engine's own bits: the standard distributions differ between libraries.
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

// Parts of a street along x, on the side of y that `side` (1 or -1) tells.
[[nodiscard]] StreetSolid street_box(StreetMaterial material,
                                     const Eigen::Vector3d& low,
                                     const Eigen::Vector3d& high,
                                     const Eigen::Vector3d& tint,
                                     double reflectance);
/// Houses from x = from_m on, the last one beginning before to_m.
void add_street_buildings(
    std::vector<StreetSolid>& to, StreetDice& dice, double side, double from_m, double to_m);
/// Lamps, trees and parked cars.
void add_street_furniture(
    std::vector<StreetSolid>& to, StreetDice& dice, double side, double from_m, double to_m);
/// A car whose middle stands on the road at `at`, as long as the x axis.
void add_street_car(std::vector<StreetSolid>& to, const Eigen::Vector3d& at, const Eigen::Vector3d& tint);

/// Sun and sky light, the same all day: no cast shadows, so that appearance depends on the surface alone.
[[nodiscard]] double street_light(const Eigen::Vector3d& normal);

/// Windows, doors and shops of a house stand in so many bays of that width, m.
struct StreetBays {
  int count = 1;
  double width = 0.0;
};
[[nodiscard]] StreetBays street_bays(const StreetSolid& house);
/// Whether the plain street's paint is there on the road.
[[nodiscard]] bool street_lane_marking(double x, double y);

[[nodiscard]] StreetWorld build_street_world(const StreetContents& contents);
/// Colour and reflectance of `solid`, without a style, at `point` (in the solid's frame, on the surface with
/// that normal). No pattern is finer than a pixel.
[[nodiscard]] StreetSurface street_surface(const StreetSolid& solid,
                                           const Eigen::Vector3d& point,
                                           const Eigen::Vector3d& normal,
                                           std::uint64_t seed);
[[nodiscard]] Eigen::Vector3d street_sky(const Eigen::Vector3d& direction);

}  // namespace simuli

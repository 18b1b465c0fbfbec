#pragma once
#include <compare>
#include <cstddef>

#include "host/runtime/build_options.hpp"
#include "host/runtime/device.hpp"

namespace simuli {

/// How the 256 rays of a tile are spread: work_items x vectors x lanes = 256 (cl/math/lanes.h).
struct LaneShape {
  int lanes = 16;
  int vectors = 16;
  int work_items = 1;
  /// CPUs: one work-item per tile, explicit vectors. GPUs: 64 scalar work-items of 4 rays.
  [[nodiscard]] static LaneShape of(const Device& device, Precision precision);
  /// The same for tiles of fewer rays, a power of two.
  [[nodiscard]] LaneShape for_tile(int tile_rays) const;
  auto operator<=>(const LaneShape&) const = default;
};

/// How a particle's extent on the sensor is found (METHOD section 4; the paper's table 8).
enum class Projection : int {
  kUnscented = 0,   // seven sigma points
  kLinearized = 1,  // the derivative at the centre, as in EWA splatting
  kMonteCarlo = 2,  // 200 samples: slow, the yardstick of the other two
};

/// Which rays a particle may contribute to (METHOD section 4): how much is lost against how much is tested.
enum class Extent : int {
  kUnscented = 0,  // those within the box of Projection; the response is clipped there
  kExact = 1,      // all with an alpha of at least alpha_cut: closed-form bounds, nothing is lost
};

/// In which order a ray blends what it meets (METHOD section 7).
enum class Order : int {
  kRange = 0,   // by the particles' distances from the sensor: one sort for all rays
  kPerRay = 1,  // by where each ray itself meets them: exact, slower; has no backward pass
};

/// From where a particle's colour is seen.
enum class ShDirection : int {
  kParticle = 0,  // from the sensor to its centre: once per particle
  kRay = 1,       // along each ray; has no backward pass
};

/// exp, atan2, sine and cosine in float; double has the built-in functions alone.
enum class Math : int {
  kFast = 0,     // polynomials with errors of 2 to 3e-7
  kPrecise = 1,  // the built-in functions: scalar calls on CPU drivers
};

/// Bands of spherical harmonics that are kept of each set.
enum class ShDegree : int {
  k0 = 0,  // up to these, or what the scene has
  k1 = 1,
  k2 = 2,
  k3 = 3,
  kAuto = 4,  // the fewest of each set that change colours by less than sh_error (sufficient_sh_degree)
};

/// How coefficients of spherical harmonics lie in device memory; sums are reals either way.
enum class ShStorage : int {
  kFull = 0,
  kHalf = 1,  // 16 bits, each rounded to nearest (11 bits): half the traffic; float only, no backward pass
};

/// The tiles of a LiDAR: what procedure 1 of the paper is asked for. Both 0: what `simuli tile --tune` has
/// found for the sensor on the device, if it has; else 0 is as suits most.
struct LidarTiles {
  int elevation = 0;  // tiles from top to bottom; more where a tile could not hold its beams
  int rays = 0;       // of one tile, at most: 16 to 256
  bool operator==(const LidarTiles&) const = default;
};

/// Whether particles that no requested ray of a LiDAR can meet are dropped before they make tile instances
/// (METHOD section 6). Pictures are the same bits either way.
enum class Culling : int {
  kOff = 0,
  kAuto = 1,    // where the ray mask has a cell without a ray
  kAlways = 2,  // even where every query must find one: for measuring
};

/// The grid that a LiDAR's rays are marked in, over the sweep and over its beams.
struct RayMaskSize {
  int columns = 1600;
  int rows = 8;
  bool equalized = true;  // rows of equally many beams, else of equal intervals of elevation
  bool operator==(const RayMaskSize&) const = default;
};

/// Every approximation of a frame, named, with its default (speed against accuracy).
struct RenderOptions {
  Precision precision = Precision::kFloat;
  Projection projection = Projection::kUnscented;
  Extent extent = Extent::kUnscented;  // kExact: projection has no effect
  Order order = Order::kRange;
  ShDirection sh_direction = ShDirection::kParticle;
  ShDegree sh_degree = ShDegree::k3;
  double sh_error = 0.002;  // of ShDegree::kAuto: RMS over directions and particles, of 1 (and of a logit)
  ShStorage sh_storage = ShStorage::kFull;
  Math math = Math::kFast;
  int shutter_iterations = 4;        // looks for a sigma point's own time, to 64; extents are bounds where it
                                     // isn't found. 0: as if all stood still half-way through the frame
  double alpha_cut = 1.0 / 255.0;    // contributions below this are not made
  double transmittance_cut = 1e-4;   // a ray is done below this
  double camera_filter_px2 = 0.3;    // variance of the pixel footprint, px^2
  bool camera_compensation = false;  // particles widened by the footprint lose opacity in proportion
  bool lidar_compensation = false;   // the same for beams: blends thin things with what is behind
  bool median_distance = true;       // write the median distance as well (LiDAR)
  LidarTiles lidar_tiles;
  Culling culling = Culling::kAuto;
  RayMaskSize ray_mask;
  LaneShape shape{0, 0, 0};                           // 0: LaneShape::of(device)
  std::size_t max_instances = std::size_t{1} << 28U;  // a frame that needs more is refused

  bool operator==(const RenderOptions&) const = default;
};

}  // namespace simuli

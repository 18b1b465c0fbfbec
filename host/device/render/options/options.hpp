#pragma once
// Options of rendering.
#include <compare>
#include <cstddef>

#include "host/core/base/allowed.hpp"
#include "host/core/base/precision.hpp"
#include "host/core/scene/pixel_footprint.hpp"

namespace simuli {

/// Distribution of a tile's 256 rays: work_items x vectors x lanes = 256 (cl/math/lanes.h).
struct LaneShape {
  int lanes = 16;
  int vectors = 16;
  int work_items = 1;
  auto operator<=>(const LaneShape&) const = default;
};

/// Method of finding a particle's extent on the sensor (METHOD section 4; the paper's table 8).
enum class Projection : int {
  kUnscented = 0,   // seven sigma points
  kLinearized = 1,  // the derivative at the centre, as in EWA splatting
  kMonteCarlo = 2,  // 200 samples: slow, the reference of the other two
};

/// Rays that a particle may contribute to (METHOD section 4): a trade between lost contributions and tests.
enum class Extent : int {
  kUnscented = 0,  // rays inside the box of Projection, which clips the response
  kExact = 1,      // all rays with alpha >= alpha_cut: closed-form bounds without loss
};

/// Order in which a ray blends particles (METHOD section 7).
enum class Order : int {
  kRange = 0,   // by the particles' distance from the sensor: one sort for all rays
  kWindow = 1,  // by the distance along each ray, within a window of that order
  kPerRay = 2,  // by the distance along each ray: exact
};

/// Viewing direction for spherical harmonics.
enum class ShDirection : int {
  kParticle = 0,  // from the sensor to the particle's centre: once per particle
  kRay = 1,       // along each ray; without backward pass
};

/// Storage of spherical-harmonics coefficients in device memory; arithmetic uses reals.
enum class ShStorage : int {
  kFull = 0,
  kHalf = 1,  // 16 bits, rounded to nearest (11 bits): half the traffic; float only, without backward pass
};

/// Whether particles that no requested LiDAR ray hits are dropped before binning (METHOD section 6). Results
/// have the same bits either way.
enum class Culling : int {
  kOff = 0,
  kAuto = 1,  // if the ray mask has an empty cell
};

/// RenderOptions::camera_filter_px2: the filter that the scene was trained with (Scene::camera_filter_px2),
/// which is part of its particles' meaning; kPixelVariance_px2 in training and without a scene.
inline constexpr double kOfScene = -1.0;

/// Options that determine the upload of particles.
struct UploadOptions {
  int sh_degree = 3;
  ShStorage sh_storage = ShStorage::kFull;
  int particle_memory_mb = 0;
  bool operator==(const UploadOptions&) const = default;
};
template <class F>
constexpr void visit_fields(UploadOptions& o, F&& field) {
  field("render.sh_degree",
        o.sh_degree,
        range(0, 3),
        "Bands of spherical harmonics, at most. Fewer: less memory, no highlights.",
        InTraining::kNoGradients);
  field("render.sh_storage",
        o.sh_storage,
        one_of("full", "half"),
        "Coefficients on the device: as computed, or of 16 bits (float alone). half: less memory, faster.",
        InTraining::kNoGradients);
  field("render.particle_memory_mb",
        o.particle_memory_mb,
        range(0, 1 << 24),
        "MiB of the device for the particles of either set; of larger sets those are there that frames see. "
        "0: a third of the device. The same bits either way.",
        InTraining::kFixed);
}

/// Options that determine a sensor's rays on the device.
struct RayOptions {
  double camera_filter_px2 = kOfScene;
  double camera_near_m = 0.01;
  Culling culling = Culling::kAuto;
  bool operator==(const RayOptions&) const = default;
};
template <class F>
constexpr void visit_fields(RayOptions& o, F&& field) {
  field("render.camera_filter_px2",
        o.camera_filter_px2,
        either(kOfScene, range(0.0, 100.0)),
        "Variance of a pixel's footprint in px^2. 0.3: for splat viewers; -1: the scene's, in training a "
        "square pixel's 1/12.");
  field("render.camera_near_m",
        o.camera_near_m,
        range(0.01, 1000.0),
        "Near limit of cameras in m. More: nothing of the ego vehicle in front of the lens.");
  field(
      "render.culling",
      o.culling,
      one_of("off", "auto"),
      "Drop particles that no requested ray intersects (of a camera: outside the rectangle of its requested "
      "pixels): never, or where that saves time. The same bits either way.",
      InTraining::kFixed);
}

/// Options that kernels are compiled for.
struct ProgramOptions {
  Projection projection = Projection::kUnscented;
  Extent extent = Extent::kExact;  // as accurate as the paper's boxes, and faster with moving sensors
  Order order = Order::kRange;
  int window = 64;
  ShDirection sh_direction = ShDirection::kParticle;
  int shutter_iterations = 4;  // without convergence extents are bounds
  bool camera_compensation = false;
  bool lidar_compensation = false;  // blends thin objects with their background
  bool median_distance = true;
  LaneShape shape{0, 0, 0};  // 0: chosen for the device (lane_shape_of())
  bool operator==(const ProgramOptions&) const = default;
};
template <class F>
constexpr void visit_fields(ProgramOptions& o, F&& field) {
  field("render.projection",
        o.projection,
        one_of("unscented", "linearized", "monte_carlo"),
        "Computation of a particle's box on the sensor, with render.extent=unscented: from sigma points, the "
        "derivative or 200 samples. For comparisons with the paper.");
  field("render.extent",
        o.extent,
        one_of("unscented", "exact"),
        "Rays that a particle contributes to: those in the box of render.projection (the paper's), or all "
        "with an alpha of at least render.alpha_cut.");
  field("render.order",
        o.order,
        one_of("range", "window", "per_ray"),
        "Order in which a ray blends particles: by their distances from the sensor, or along the ray, among "
        "the render.window latest or all. per_ray: exact, slowest.");
  field("render.window",
        o.window,
        range(2, 64),
        "Particles among which order=window chooses the nearest. More: more exact, slower; with per_ray it "
        "changes time alone.",
        InTraining::kFixed);
  field("render.sh_direction",
        o.sh_direction,
        one_of("particle", "ray"),
        "Viewing direction of colours: from the sensor, once per particle, or along each ray. ray: exact, "
        "slower.",
        InTraining::kNoGradients);
  field("render.shutter_iterations",
        o.shutter_iterations,
        range(0, 64),
        "Iterations that find the time at which a moving sensor sees a point. Fewer: faster; 0: the scene is "
        "static at the middle of the frame.");
  field("render.camera_compensation",
        o.camera_compensation,
        "Reduce the opacity of particles that a pixel's footprint widens. true: for splats trained so "
        "(antialiased).");
  field("render.lidar_compensation",
        o.lidar_compensation,
        "The same for beams. true: thin objects blend with the background.");
  field("render.median_distance",
        o.median_distance,
        "LiDARs also measure the median distance, at a transmittance of a half. false: slightly faster.",
        InTraining::kFixed);
  field.internal(o.shape);  // determined by the device
}

/// Options passed to kernels with each frame.
struct FrameOptions {
  double alpha_cut = 1.0 / 255.0;
  double transmittance_cut = 1e-4;
  double detail = 0.0;  // kernels and uploads depend on whether it is 0
  std::size_t max_pairs = std::size_t{1} << 28U;
  bool operator==(const FrameOptions&) const = default;
};
template <class F>
constexpr void visit_fields(FrameOptions& o, F&& field) {
  field("render.alpha_cut",
        o.alpha_cut,
        range(1e-30, 0.5),
        "Opacity below which a particle is skipped in a ray. More: faster, less exact.");
  field("render.transmittance_cut",
        o.transmittance_cut,
        range(0.0, 0.5),
        "Transmittance below which a ray terminates early. More: faster, less exact.");
  field("render.detail",
        o.detail,
        range(0.0, 100.0),
        "Width in rays (standard deviation) below which particles are merged into fewer, larger ones. 0.5: "
        "three "
        "times as fast along long streets; 0: off.",
        InTraining::kNoGradients);
  field(
      "render.max_pairs",
      o.max_pairs,
      at_least(1),
      "Maximum number of tile-Gaussian pairs; a frame that needs more is refused. Lower it to bound memory.",
      InTraining::kFixed);
}

/// All approximations of a frame: speed against accuracy. The defaults apply wherever nothing is specified
/// (Quality::kBalanced) and equal the paper's except for the extents (paper_options()). Each base struct
/// determines one kind of device data, which is reused while that struct and the precision stay equal.
struct RenderOptions : UploadOptions, RayOptions, ProgramOptions, FrameOptions {
  Precision precision = Precision::kFloat;
  bool operator==(const RenderOptions&) const = default;
};

/// The setting keys with allowed values and help (host/core/base/fields.hpp).
template <class F>
constexpr void visit_fields(RenderOptions& o, F&& field) {
  field("render.precision",
        o.precision,
        one_of("float", "double"),
        "Of all numbers on the device. double: exact to 1e-12, much slower.",
        InTraining::kFixed);
  field.part("", static_cast<ProgramOptions&>(o));
  field.part("", static_cast<UploadOptions&>(o));
  field.part("", static_cast<RayOptions&>(o));
  field.part("", static_cast<FrameOptions&>(o));
}

/// Returns the filter in px^2 for frames with these options in a scene trained with `of_scene`.
[[nodiscard]] constexpr double camera_filter_px2(const RayOptions& options,
                                                 double of_scene = kPixelVariance_px2) {
  return options.camera_filter_px2 == kOfScene ? of_scene : options.camera_filter_px2;
}

/// Returns the paper's options: extents from boxes that clip responses.
[[nodiscard]] constexpr RenderOptions paper_options() {
  RenderOptions options;
  options.extent = Extent::kUnscented;
  return options;
}

}  // namespace simuli

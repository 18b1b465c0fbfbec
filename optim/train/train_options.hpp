#pragma once
// Options of a training.
#include <cstddef>
#include <string>

#include "host/core/base/allowed.hpp"
#include "host/device/render/options/options.hpp"
#include "optim/actors/pose_rates.hpp"
#include "optim/train/length_options.hpp"
#include "optim/train/paper/anchor_options.hpp"
#include "optim/train/schedule.hpp"
#include "optim/train/structure_options.hpp"

namespace simuli {

/// Weights of the LiDAR set's losses, each a mean over rays (METHOD section 10). Only their ratios matter,
/// because the set has no other loss and Adam's steps do not depend on the loss scale. The paper's 0.01 for
/// distance applies next to a picture loss; without one, distances need more weight against ray drops.
struct LidarWeights {
  double distance = 0.5;
  double intensity = 0.1;
  double drop = 0.05;
};
template <class F>
constexpr void visit_fields(LidarWeights& o, F&& field) {
  field.group("LiDAR set");
  field("loss.drop",
        o.drop,
        at_least(0.0),
        "Weight of the ray-drop loss (cross entropy), relative to 0.5 per metre of distance. More: truer "
        "drops, less exact distances.");
  field.internal(o.distance);
  field.internal(o.intensity);
}

/// Training of the LiDARs' ray-drop functions (METHOD section 7).
struct RayDropOptions {
  double rate = 0.1;  // of the function's parameters per step of Adam; 0: only the particles' drop logits
  /// One of so many sweeps trains only the function, the others only the particles; 0: all sweeps train both.
  int apart = 5;
};

/// Weights of a picture's losses (METHOD section 10), each a mean over its values.
struct ImageWeights {
  double absolute = 0.8;
  double squared = 10.0;
  double dissimilarity = 0.4;
  double sky = 0.01;  // on opacity at sky pixels
};
template <class F>
constexpr void visit_fields(ImageWeights& o, F&& field) {
  field.group("Camera set");
  field("loss.ssim",
        o.dissimilarity,
        at_least(0.0),
        "Weight of 1 - SSIM in a picture's loss. More: crisper structure, lower PSNR; 0: faster.");
  field.internal(o.absolute);
  field.internal(o.squared);
  field.internal(o.sky);
}

/// Pictures that share a colour transform (bilateral grid).
enum class ColorGridsOf : int {
  kAuto = 0,  // kPictures with one camera, else one grid per camera for all its pictures
  kPictures = 1,
  kNone = 2,
};

/// Environment map and bilateral colour grids of the camera set.
struct AppearanceOptions {
  /// docs/DECISIONS.md, "Colour grids".
  ColorGridsOf color_grids = ColorGridsOf::kAuto;
  double environment_rate = 1e-2;  // of texels per step of Adam, initially
  double grid_rate = 2e-3;         // of grid values, with enough steps per grid
  double least_share = 0.8;
};
template <class F>
constexpr void visit_fields(AppearanceOptions& o, F&& field) {
  field.group("Camera set");
  field("color_grids",
        o.color_grids,
        one_of("auto", "pictures", "none"),
        "Images that share a bilateral grid for exposure and white balance. auto: each picture of a single "
        "camera, else each camera; none: frames render a seventh faster.");
  field.internal(o.environment_rate);
  field.internal(o.grid_rate);
  field("appearance.least_share",
        o.least_share,
        at_least(0.0),
        "Share of a picture, relative to an average particle's, below which a particle's colour is frozen, "
        "and below a tenth its position. More: better off-trajectory views, less detail on the trajectory; "
        "0: none are frozen.");
}

/// Depth supervision of the camera set along LiDAR rays: pictures alone leave depth ambiguous.
struct DepthOptions {
  double weight = 0.1;
  int every = 2;  // iterations per sweep
  /// Sectors of a sweep; one is used per step.
  static constexpr std::size_t kSectors = 4;
};
template <class F>
constexpr void visit_fields(DepthOptions& o, F&& field) {
  field.group("Camera set");
  field("depth.weight",
        o.weight,
        at_least(0.0),
        "Weight of the camera set's distance error in m along LiDAR rays. More: better off-trajectory "
        "views, lower PSNR on the trajectory; 0: off, faster.");
  field.internal(o.every);
}

/// Supervision of the camera set in off-trajectory views (METHOD section 10), where no picture was recorded.
struct OffTrajectoryOptions {
  /// Iterations per picture (docs/DECISIONS.md, "Off-trajectory views").
  static constexpr int kEvery = 2;
  double weight = 0.5;
  double reach_m = 2.5;
};
template <class F>
constexpr void visit_fields(OffTrajectoryOptions& o, F&& field) {
  field.group("Camera set");
  field("off_trajectory.weight",
        o.weight,
        at_least(0.0),
        "Weight of off-trajectory pictures, made of the LiDARs' surfaces in the colours of the recorded "
        "pictures. More: better off-trajectory views; 0: off, faster.");
  field("off_trajectory.reach_m",
        o.reach_m,
        range(0.0, 10.0),
        "Largest lateral distance in m of these views from the trajectory. As far as cameras will leave "
        "the trajectory.");
}

/// Several frames per step, and devices that share them (METHOD section 10).
struct ShardOptions {
  int count = 1;
  /// Rates are multiplied by the number of shards to this power (docs/DECISIONS.md, "Shards and ranks").
  double rate_power = 0.5;
};
template <class F>
constexpr void visit_fields(ShardOptions& o, F&& field) {
  field.group("Length");
  field("shards",
        o.count,
        range(1, 1024),
        "Pictures and sweeps whose gradients each iteration averages. As many devices or ranks can share a "
        "training.");
  field.internal(o.rate_power);
}

struct TrainOptions {
  int iterations = 1500;
  LengthOptions length;
  ShardOptions shards;
  int lidar_every = 2;  // LiDAR geometry starts at the returns and needs fewer steps than colours
  double max_seconds = 0.0;
  ImageWeights image;
  AppearanceOptions appearance;
  LearningRates camera;
  /// High rates overfit ray drops, which differ from sweep to sweep (docs/DECISIONS.md, "Learning rates").
  LearningRates lidar{.mean_m = 2e-3,
                      .mean_final_m = 1e-5,
                      .log_scale = 4e-2,
                      .rotation = 5e-3,
                      .opacity = 5e-2,
                      .sh = 5e-3,
                      .sh_rest = 2.5e-4,
                      .final_share = 0.1,
                      .last_share = 1.0};
  LidarWeights weights;
  DepthOptions depth;
  OffTrajectoryOptions off_trajectory;
  RayDropOptions ray_drop;
  AnchorOptions anchor;
  DensifyOptions densify;
  PruneOptions prune;
  PoseRates actor_poses;
  bool learn_shapes = true;  // of non-rigid actors: pedestrians and riders
  /// In float precision; the median distance has no gradient and is not computed.
  RenderOptions render;
  std::size_t memory_bytes = 0;
  std::size_t cache_bytes = std::size_t{2} << 30U;
  std::size_t host_cache_bytes = std::size_t{2} << 30U;
};

/// The setting keys with allowed values and help (host/core/base/fields.hpp).
template <class F>
constexpr void visit_fields(TrainOptions& o, F&& field) {
  field.group("Length");
  field("iterations",
        o.iterations,
        at_least(0),
        "Training steps, one picture each. More: sharper pictures, slower; beyond 1500 off-trajectory "
        "views get worse.");
  field.part("", o.length);
  field.part("", o.shards);
  field("max_seconds",
        o.max_seconds,
        at_least(0.0),
        "Time in s after which training stops early, less converged than a training of fewer iterations; "
        "0: never.");
  field.group("LiDAR set");
  field("lidar_every",
        o.lidar_every,
        at_least(1),
        "Iterations per sweep of a LiDAR; with several LiDARs at most one sweep per iteration. 1: better "
        "LiDAR, slower; more: faster.");
  field.part("", o.image);
  field.part("", o.appearance);
  field.part("", o.camera);
  field.internal(o.lidar);
  field.part("", o.weights);
  field.part("", o.depth);
  field.part("", o.off_trajectory);
  field.internal(o.ray_drop);
  field.part("", o.anchor);
  field.part("", o.densify);
  field.part("", o.prune);
  field.part("", o.actor_poses);
  field.group("Actors");
  field("actors.shape.learn",
        o.learn_shapes,
        "Learn the deformation of people and riders. false: faster, blurred legs.");
  field.group("Memory");
  field("memory_bytes",
        o.memory_bytes,
        at_least(0),
        "Limit of device memory in bytes; a drive that needs more is split into chunks. 0: all device "
        "memory.");
  field("cache_bytes",
        o.cache_bytes,
        at_least(0),
        "Bytes of pictures, and of sweeps, cached on the device. More: fewer copies, faster.");
  field("host_cache_bytes",
        o.host_cache_bytes,
        at_least(0),
        "Bytes of frames cached in host memory, up to a quarter of it. More: fewer file reads.");
  field.group("Rendering");
  field.part_in_training("", o.render);
}

/// Returns the options. Throws Error{kUsage} with the key of an option outside its range.
[[nodiscard]] TrainOptions checked(const TrainOptions& options);

/// Returns the quality bundle (host/device/render/options/quality.hpp) that the options equal, or "custom".
[[nodiscard]] std::string quality_of(const RenderOptions& options);

}  // namespace simuli

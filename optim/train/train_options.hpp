#pragma once
// What a training is told.
#include <cstddef>
#include <string>

#include "host/base/allowed.hpp"
#include "host/render/options/options.hpp"
#include "optim/length/length_options.hpp"
#include "optim/poses/pose_rates.hpp"
#include "optim/poses/shape_rates.hpp"
#include "optim/train/schedule.hpp"
#include "optim/train/structure_options.hpp"

namespace simuli {

/// Weights of the LiDAR set's losses, each a mean over its rays (METHOD section 10). Only their ratios
/// matter: the set has no other loss, and Adam's steps do not depend on the loss's scale. METHOD's 0.01 is
/// the weight beside a picture's loss; alone, distances need more to hold their own against the drops.
struct LidarWeights {
  double distance = 0.5;
  double intensity = 0.1;
  double drop = 0.05;
};
template <class F>
constexpr void visit_fields(LidarWeights& o, F&& field) {
  field("loss.distance", o.distance, at_least(0.0), "of a sweep's mean |d^ - d| in m, returned rays");
  field("loss.intensity", o.intensity, at_least(0.0), "of its mean |i^ - i|, returned rays");
  field("loss.drop", o.drop, at_least(0.0), "of the cross entropy of its ray drop, all rays");
}

/// How the LiDARs' drop functions are learned (METHOD section 7).
struct RayDropOptions {
  double rate = 0.1;
  double final_share = 0.1;
  int apart = 5;
  int looks = 10;  // cheap: the sweep is rendered once
};
template <class F>
constexpr void visit_fields(RayDropOptions& o, F&& field) {
  field("ray_drop.rate",
        o.rate,
        at_least(0.0),
        "per step of Adam, of the parameters of a LiDAR's drop function; 0: drops are those of hit and drop "
        "logits alone");
  field("ray_drop.final_share", o.final_share, above(0.0, 1.0), "of it, at the end");
  field("ray_drop.looks", o.looks, at_least(1), "steps of the function on a sweep that teaches it");
  field("ray_drop.apart",
        o.apart,
        at_least(0),
        "every how many sweeps the drops of one teach the function alone, and those of the others particles "
        "alone; 0: all teach both");
}

/// Weights of a picture's losses (METHOD section 10), each a mean over its values.
struct ImageWeights {
  double absolute = 0.8;
  double squared = 10.0;
  double dissimilarity = 0.2;
};
template <class F>
constexpr void visit_fields(ImageWeights& o, F&& field) {
  field("loss.colour_absolute", o.absolute, at_least(0.0), "of a picture's mean |d|");
  field("loss.colour_squared", o.squared, at_least(0.0), "of its mean d^2");
  field("loss.ssim", o.dissimilarity, at_least(0.0), "of 1 - SSIM");
}

/// Environment and colour grids of the camera set.
struct LookOptions {
  bool color_grids = false;
  double environment_rate = 1e-2;
  double grid_rate = 2e-3;
  double final_share = 0.1;
  double environment_variation = 0.0;
  double grid_variation = 10.0;
  double grid_drift = 0.001;
  double least_share = 0.6;
};
template <class F>
constexpr void visit_fields(LookOptions& o, F&& field) {
  field("color_grids", o.color_grids, "a bilateral colour grid for each training picture");
  field("look.rate.environment",
        o.environment_rate,
        at_least(0.0),
        "per step of Adam, of texels, at the start");
  field("look.rate.grid", o.grid_rate, at_least(0.0), "per step, of colour grids");
  field("look.rate.final_share", o.final_share, above(0.0, 1.0), "of both rates, at the end");
  field("loss.environment_variation",
        o.environment_variation,
        at_least(0.0),
        "of the mean squared difference of neighbouring texels: those that no picture looks at become like "
        "those around them");
  field("loss.grid_variation", o.grid_variation, at_least(0.0), "of that of neighbouring vertices of a grid");
  field("loss.grid_drift",
        o.grid_drift,
        at_least(0.0),
        "of the mean squared difference of grids to the identity");
  field("look.least_share",
        o.least_share,
        at_least(0.0),
        "of what a particle has of a picture that all share alike: what fills it moves its colours at "
        "half their rate, and what no picture shows, but for a trace, keeps those that it began with; "
        "texels of the environment likewise; 0: all move");
}

/// The camera set along the LiDARs' rays: pictures alone leave open how far away what they show is.
struct DepthOptions {
  double weight = 0.1;
  int every = 2;
};
template <class F>
constexpr void visit_fields(DepthOptions& o, F&& field) {
  field("depth.weight",
        o.weight,
        at_least(0.0),
        "of the camera set's mean |d^ - d| in m along a sweep's returned rays; 0: none");
  field("depth.every", o.every, at_least(1), "iterations per sweep that the camera set is compared with");
}

/// The camera set from beside the path (METHOD section 10): pictures alone leave open what it looks like from
/// where none was taken.
struct BesideOptions {
  double weight = 0.5;
  int every = 2;
  double reach_m = 2.5;
};
template <class F>
constexpr void visit_fields(BesideOptions& o, F&& field) {
  field("beside.weight",
        o.weight,
        at_least(0.0),
        "of a picture's loss from beside the path, where it shows the surfaces that the LiDARs met in the "
        "colours that the picture on the path has of them; 0: none");
  field("beside.every", o.every, at_least(1), "iterations per such a picture");
  field("beside.reach_m", o.reach_m, range(0.0, 10.0), "m, how far to either side of the path, evenly drawn");
}

/// Several frames for one step, and devices that share them (METHOD section 10).
struct ShardOptions {
  int count = 1;
  double rate_power = 0.5;
};
template <class F>
constexpr void visit_fields(ShardOptions& o, F&& field) {
  field(
      "shards",
      o.count,
      range(1, 1024),
      "frames of which a step takes the mean, a picture and a sweep each; as many ranks and devices at most "
      "can share them");
  field("shards.rate_power",
        o.rate_power,
        range(0.0, 1.0),
        "the particles' rates are those of one shard times the shards' number to this power");
}

struct TrainOptions {
  int iterations = 1500;
  LengthOptions length;
  ShardOptions shards;
  int lidar_every = 2;  // returns start where they belong, colours do not
  double max_seconds = 0.0;
  ImageWeights image;
  LookOptions look;
  LearningRates camera{.final_share = 0.3};
  /// Returns are where they are: nearly fixed. Drops differ from sweep to sweep: fast rates learn them by
  /// heart.
  LearningRates lidar{.mean_m = 2e-3, .mean_final_m = 2e-5, .opacity = 5e-2, .sh = 5e-3, .sh_rest = 2.5e-4};
  LidarWeights weights;
  DepthOptions depth;
  BesideOptions beside;
  RayDropOptions ray_drop;
  AnchorOptions anchor;
  DensifyOptions densify;
  PruneOptions prune;
  PoseRates actor_poses;
  ShapeRates actor_shapes;
  double actor_margin_m = 0.1;
  /// In float; the median distance has no gradient and is never written.
  RenderOptions render;
  std::size_t memory_bytes = 0;
  std::size_t cache_bytes = std::size_t{2} << 30U;
  std::size_t host_cache_bytes = std::size_t{2} << 30U;
};

/// The keys that users set, with what is allowed and what it means (host/base/fields.hpp).
template <class F>
constexpr void visit_fields(TrainOptions& o, F&& field) {
  field("iterations", o.iterations, at_least(0), "one picture each, or one of each shard");
  field.part("", o.length);
  field.part("", o.shards);
  field("max_seconds",
        o.max_seconds,
        at_least(0.0),
        "s, stop training early after this time, the rates not yet run down; 0: never");
  field("lidar_every", o.lidar_every, at_least(1), "iterations per sweep");
  field.part("", o.image);
  field.part("", o.look);
  field.part("camera.", o.camera);
  field.part("lidar.", o.lidar);
  field.part("", o.weights);
  field.part("", o.depth);
  field.part("", o.beside);
  field.part("", o.ray_drop);
  field.part("", o.anchor);
  field.part("", o.densify);
  field.part("", o.prune);
  field.part("", o.actor_poses);
  field.part("", o.actor_shapes);
  field(
      "actors.margin_m", o.actor_margin_m, at_least(0.0), "m by which particles may leave their actor's box");
  field("memory_bytes",
        o.memory_bytes,
        at_least(0),
        "of the device, that the training may need; 0: all it has");
  field("cache_bytes", o.cache_bytes, at_least(0), "of frames kept on the device, pictures and sweeps each");
  field("host_cache_bytes",
        o.host_cache_bytes,
        at_least(0),
        "of frames kept on the host as they were read; a quarter of its memory and an eighth of "
        "--host-memory at most");
  field.part_in_training("", o.render);
}

/// The options themselves. Error{kUsage} naming the key when one is outside its range.
[[nodiscard]] TrainOptions checked(const TrainOptions& options);

/// The name of the bundle (host/render/options/quality.hpp) that these options of a training are, or
/// "custom".
[[nodiscard]] std::string quality_of(const RenderOptions& options);

}  // namespace simuli

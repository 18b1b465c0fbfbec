#pragma once
// What a training is told.
#include <cstddef>
#include <string>

#include "host/core/base/allowed.hpp"
#include "host/device/render/options/options.hpp"
#include "optim/train/length_options.hpp"
#include "optim/actors/pose_rates.hpp"
#include "optim/train/schedule.hpp"
#include "optim/train/structure_options.hpp"

namespace simuli {

/// Weights of the LiDAR set's losses, each a mean over its rays (METHOD section 10). Only their ratios
/// matter: the set has no other loss, and Adam's steps do not depend on the loss's scale. METHOD's 0.01 is
/// the weight beside a picture's loss; alone, distances need more to hold their own against the drops.
struct LidarWeights {
  double distance = 0.5;  // 2: 3.91 cm for 3.94 on drive 0013, all else the same
  double intensity = 0.1;
  double drop = 0.05;
};
template <class F>
constexpr void visit_fields(LidarWeights& o, F&& field) {
  field.group("LiDAR set");
  field("loss.drop",
        o.drop,
        at_least(0.0),
        "Weight of errors of ray drop (cross entropy), beside 0.5 for each metre of distance. More: truer "
        "drops, less exact distances.");
  field.internal(o.distance);
  field.internal(o.intensity);
}

/// How the LiDARs' drop functions are learned (METHOD section 7).
struct RayDropOptions {
  double rate = 0.1;  // per step of Adam, of a function's parameters; 0: drops are the logits' alone
  /// Of so many sweeps one teaches the function alone, and the others particles alone; 0: all teach both.
  int apart = 5;
};

/// Weights of a picture's losses (METHOD section 10), each a mean over its values.
struct ImageWeights {
  double absolute = 0.8;
  double squared = 10.0;
  double dissimilarity = 0.4;
  double sky = 0.01;  // of opacity where a picture shows sky
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

/// What learns a colour transform of its own.
enum class ColorGridsOf : int {
  kAuto = 0,  // kPictures where one camera trains, else each camera, for all its pictures
  kPictures = 1,
  kNone = 2,
};

/// Environment and colour grids of the camera set.
struct AppearanceOptions {
  /// Quarter size, none and kAuto: drive 0013 after 500 iterations 25.38 and 26.03 dB; when grids were slower, after
  /// 200 to 400, 0052 27.99 and 28.30, the street 30.41 and 30.44, PandaSet 28.92 and 29.77 (kPictures 29.15: six
  /// cameras show each too rarely).
  ColorGridsOf color_grids = ColorGridsOf::kAuto;
  double environment_rate = 1e-2;  // per step of Adam, of texels, at the start
  double grid_rate = 2e-3;         // of the grids' values, where they take steps enough
  double least_share = 0.8;
};
template <class F>
constexpr void visit_fields(AppearanceOptions& o, F&& field) {
  field.group("Camera set");
  field("color_grids",
        o.color_grids,
        one_of("auto", "pictures", "none"),
        "What learns colour transforms for exposure and white balance. auto: each picture of a single "
        "camera, each of several cameras; none: frames render a seventh faster.");
  field.internal(o.environment_rate);
  field.internal(o.grid_rate);
  field("appearance.least_share",
        o.least_share,
        at_least(0.0),
        "Share of a picture, over that of an average particle, below which a particle keeps its first colour, "
        "and below a tenth its place. More: better views beside the path, less detail on it; 0: all learn.");
}

/// The camera set along the LiDARs' rays: pictures alone leave open how far away what they show is.
struct DepthOptions {
  double weight = 0.1;
  int every = 2;  // iterations per sweep; each would take twice the time of it: not measured
  /// Of a sweep, of which one is taken at a time.
  static constexpr std::size_t kSectors = 4;
};
template <class F>
constexpr void visit_fields(DepthOptions& o, F&& field) {
  field.group("Camera set");
  field("depth.weight",
        o.weight,
        at_least(0.0),
        "Weight of the camera set's distance error in m along LiDAR rays. More: better views beside the "
        "path, lower PSNR on it; 0: off, faster.");
  field.internal(o.every);
}

/// The camera set from beside the path (METHOD section 10): pictures alone leave open what it looks like from
/// where none was taken.
struct OffTrajectoryOptions {
  /// Iterations per picture. Weight 1 every 4: 27.04 dB for 27.13, 1 m beside the path.
  static constexpr int kEvery = 2;
  double weight = 0.5;
  double reach_m = 2.5;
};
template <class F>
constexpr void visit_fields(OffTrajectoryOptions& o, F&& field) {
  field.group("Camera set");
  field(
      "off_trajectory.weight",
      o.weight,
      at_least(0.0),
      "Weight of pictures from beside the path, made of the LiDARs' surfaces in the colours of the recorded "
      "pictures. More: better views beside the path; 0: off, faster.");
  field("off_trajectory.reach_m",
        o.reach_m,
        range(0.0, 10.0),
        "Distance in m to either side of the path from which these pictures are taken. As far as cameras "
        "will leave the path.");
}

/// Several frames for one step, and devices that share them (METHOD section 10).
struct ShardOptions {
  int count = 1;
  /// Rates are those of one shard times the shards' number to this power. Street, 400 frames, 2 and 4 shards:
  /// 0: 27.89 and 27.41 dB, 0.33 and 0.40 cm; 0.5: 28.08 and 28.02 dB, 0.34 and 0.43 cm; 1: 28.34 and 28.10
  /// dB, 0.35 and 0.53 cm.
  double rate_power = 0.5;
};
template <class F>
constexpr void visit_fields(ShardOptions& o, F&& field) {
  field.group("Length");
  field("shards",
        o.count,
        range(1, 1024),
        "Pictures and sweeps of which each iteration takes the mean. As many devices or ranks can share a "
        "training.");
  field.internal(o.rate_power);
}

struct TrainOptions {
  int iterations = 1500;
  LengthOptions length;
  ShardOptions shards;
  int lidar_every = 2;  // returns start where they belong, colours do not
  double max_seconds = 0.0;
  ImageWeights image;
  AppearanceOptions appearance;
  LearningRates camera;
  /// Drops differ from sweep to sweep: fast rates learn them by heart. Scales half as fast: 2.50 cm for 2.14 and
  /// 0.728 drops found for 0.742 on drive 0052 after 250 iterations, 1.69 and 1.61 cm after 1000. Means twice as
  /// fast: PandaSet 1.98 cm for 1.93, MeanRelL2 0.0238 for 0.0208, drops 0.9687 for 0.9692. No
  /// fall at the end: 2.12 for 2.10 cm on 0052 after 300 iterations.
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
  bool learn_shapes = true;  // of actors that are not rigid: people, and who rides what has no cabin
  /// In float; the median distance has no gradient and is never written.
  RenderOptions render;
  std::size_t memory_bytes = 0;
  std::size_t cache_bytes = std::size_t{2} << 30U;
  std::size_t host_cache_bytes = std::size_t{2} << 30U;
};

/// The keys that users set, with what is allowed and what it means (host/core/base/fields.hpp).
template <class F>
constexpr void visit_fields(TrainOptions& o, F&& field) {
  field.group("Length");
  field("iterations",
        o.iterations,
        at_least(0),
        "Steps of training, one picture each. More: sharper pictures, longer; beyond 1500 views beside the "
        "path get worse.");
  field.part("", o.length);
  field.part("", o.shards);
  field("max_seconds",
        o.max_seconds,
        at_least(0.0),
        "Time in s after which training stops early, less settled than one of fewer iterations; 0: never.");
  field.group("LiDAR set");
  field("lidar_every",
        o.lidar_every,
        at_least(1),
        "Iterations for each sweep of a LiDAR that is trained on; of several one sweep an iteration at most. 1: "
        "better LiDAR, slower; more: faster.");
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
        "Learn how people and riders change their shape. false: faster, legs blur.");
  field.group("Memory");
  field("memory_bytes",
        o.memory_bytes,
        at_least(0),
        "Bytes of the device's memory that training may use; a drive that needs more is cut into stretches. "
        "0: all there are.");
  field("cache_bytes",
        o.cache_bytes,
        at_least(0),
        "Bytes of pictures, and of sweeps, kept on the device. More: fewer copies, faster.");
  field("host_cache_bytes",
        o.host_cache_bytes,
        at_least(0),
        "Bytes of frames kept in the host's memory as they were read, up to a quarter of it. More: fewer "
        "reads of files.");
  field.group("Rendering");
  field.part_in_training("", o.render);
}

/// The options themselves. Error{kUsage} naming the key when one is outside its range.
[[nodiscard]] TrainOptions checked(const TrainOptions& options);

/// The name of the bundle (host/device/render/options/quality.hpp) that these options of a training are, or
/// "custom".
[[nodiscard]] std::string quality_of(const RenderOptions& options);

}  // namespace simuli

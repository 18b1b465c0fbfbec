#pragma once
// What a training is told.
#include <cstddef>
#include <cstdint>

#include "host/render/options/options.hpp"
#include "optim/poses/actor_poses.hpp"
#include "optim/train/schedule.hpp"
#include "optim/train/structure_options.hpp"

namespace simuli {

/// Weights of the LiDAR set's losses, each a mean over its rays (METHOD section 10). Only their ratios
/// matter: Adam's steps do not depend on the loss's scale, and unless asked for the set has no other loss.
/// The paper's 0.01 is the weight beside a picture's loss; alone, distances need more to hold their own
/// against the drops.
struct LidarWeights {
  double distance = 0.5;   // |d^ - d| in m, returned rays
  double intensity = 0.1;  // |i^ - i|, returned rays
  double drop = 0.05;      // cross entropy, all rays
};

/// Weights of a picture's losses (METHOD section 10), each a mean over its values: of |d|, of d^2, of 1 -
/// SSIM.
struct ImageWeights {
  double absolute = 0.8;
  double squared = 10.0;
  double dissimilarity = 0.2;
};

/// Environment and colour grids of the camera set.
struct LookOptions {
  bool color_grids = false;        // a bilateral grid for each training picture
  double environment_rate = 1e-2;  // of Adam, per step, at the start
  double grid_rate = 2e-3;
  double final_share = 0.1;            // of the rates, at the end
  double environment_variation = 1.0;  // weight of the mean squared difference of neighbouring texels
  double grid_variation = 10.0;        // of that of neighbouring vertices
  double grid_drift = 0.001;           // of the mean squared difference to the identity
};

/// Weights of terms that hold for every particle, each a mean over the set.
struct ParticleWeights {
  double scale = 0.0;  // of the sum of its standard deviations, m
  double opacity = 0.0;
  double entropy = 0.0;  // of its opacity
};

struct TrainOptions {
  int iterations = 1500;     // one image each
  int lidar_every = 3;       // iterations per sweep: returns start where they belong, colours do not
  double max_seconds = 0.0;  // stop early after this time; 0: no limit. The schedule follows iterations
  double image_scale = 0.5;  // (0, 1]
  int held_out_every = 5;    // frames for which is_held_out() says yes are not read; 0: all are trained on
  std::uint64_t seed = 1;
  ImageWeights image;
  LookOptions look;
  ParticleWeights camera_particles, lidar_particles;
  LearningRates camera{.final_share = 0.3};
  /// Returns are where they are: nearly fixed. Drops differ from sweep to sweep: fast rates learn them by
  /// heart.
  LearningRates lidar{.mean_m = 2e-3, .mean_final_m = 2e-5, .opacity = 5e-2, .sh = 5e-3, .sh_rest = 2.5e-4};
  LidarWeights weights;
  AnchorOptions anchor;
  DensifyOptions densify;
  PoseRates actor_poses;        // 0 as they are: tracks stay as recorded
  double actor_margin_m = 0.1;  // particles of actors stay in their boxes, this much wider
  /// Leave what moved out of the losses. The background gets clean; unmasked, it takes on a smear of what
  /// moved, which is closer to the recorded pictures than nothing.
  bool mask_moving = false;
  RenderOptions render;  // in float; the median distance has no gradient and is never written
  PoseOptions poses;
  std::size_t memory_bytes = 0;  // of the device, that the training may need; 0: all it has
  std::size_t cache_bytes = std::size_t{2} << 30U;  // of frames kept on the device, images and sweeps each
};

/// The options themselves. Error{kUsage} naming the field when one is outside its range.
[[nodiscard]] TrainOptions checked(const TrainOptions& options);

}  // namespace simuli

#pragma once
// Fits the two particle sets of a scene to a log: one image per iteration, a sweep every few, Adam on each
// set.
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "host/render/renderer.hpp"
#include "host/scene/scene.hpp"
#include "io/log.hpp"
#include "optim/lru_cache.hpp"
#include "optim/moving_space.hpp"
#include "optim/schedule.hpp"

namespace simuli {

/// Weights of the LiDAR set's losses, each a mean over its rays (METHOD section 10). Only their ratios
/// matter: the set has no other loss, and Adam's steps do not depend on the loss's scale. METHOD's 0.01 is
/// the weight beside a picture's loss; alone, distances need more to hold their own against the drops.
struct LidarWeights {
  double distance = 0.5;   // |d^ - d| in m, returned rays
  double intensity = 0.1;  // |i^ - i|, returned rays
  double drop = 0.05;      // cross entropy, all rays
};

struct TrainOptions {
  int iterations = 1500;     // one image each
  int lidar_every = 3;       // iterations per sweep: returns start where they belong, colours do not
  double max_seconds = 0.0;  // stop early after this time; 0: no limit. The schedule follows iterations
  double image_scale = 0.5;  // (0, 1]
  int held_out_every = 5;    // frames for which is_held_out() says yes are not read; 0: all are trained on
  std::uint64_t seed = 1;
  double colour_squared =
      10.0;  // weight of the mean squared colour error; that of the mean absolute one is 1
  LearningRates camera{.final_share = 0.3};
  /// Returns are where they are: nearly fixed. Drops differ from sweep to sweep: fast rates learn them by
  /// heart.
  LearningRates lidar{.mean_m = 2e-3, .mean_final_m = 2e-5, .opacity = 5e-2, .sh = 5e-3, .sh_rest = 2.5e-4};
  LidarWeights weights;
  /// Leave what moved out of the losses. The background gets clean; unmasked, it takes on a smear of what
  /// moved, which is closer to the recorded pictures than nothing.
  bool mask_moving = false;
  RenderOptions render;  // in float; the median distance has no gradient and is never written
  std::size_t cache_bytes = std::size_t{2} << 30U;  // of frames kept on the device, images and sweeps each
};

/// How the training stands. Values are running means over about the last 20 frames; NaN before the first.
struct TrainStatus {
  int iteration = 0;  // done
  double psnr_db = 0.0;
  double distance_m = 0.0;     // mean |d^ - d| over returned rays, expected distance
  double drop_accuracy = 0.0;  // share of rays
};

struct TrainReport {
  TrainStatus last;
  std::size_t images = 0;  // trained on
  std::size_t sweeps = 0;
  Eigen::Index camera_particles = 0;
  Eigen::Index lidar_particles = 0;
  std::uint32_t rejected_gradients = 0;  // entries that were not finite and moved nothing; 0 in good order
  bool stopped_early = false;            // max_seconds ran out first
  double seconds = 0.0;
};

/// One training. The same device, build, log, scene and options give the same bits, unless max_seconds
/// stops it.
class Trainer {
 public:
  /// Error{kUsage} for options outside their range, Error{kInput} when the log has no frame to train on.
  /// `log` must outlive the trainer.
  /// `moving` (of the initialisation) is used when options.mask_moving.
  Trainer(const Device& device,
          const Log& log,
          Scene scene,
          const TrainOptions& options,
          MovingSpace moving = {});

  /// One iteration: a step on the camera set, and on the LiDAR set when it is its turn; each only when it has
  /// frames and particles. Error{kInput} when a frame can't be
  /// read, Error{kNumeric} when a loss is not a finite number.
  void step();
  /// All iterations that are left; `on_step` is called after each.
  TrainReport run(const std::function<void(const TrainStatus&)>& on_step = {});

  [[nodiscard]] const TrainStatus& status() const { return status_; }
  /// The scene as trained so far.
  [[nodiscard]] Scene scene() const;

 private:
  struct ImageTruth {
    RealBuffer truth;       // [3][slots], -1: not known
    std::size_t known = 0;  // pixels
  };
  struct SweepTruth {
    std::unique_ptr<SensorRays> rays;
    RealBuffer truth;          // [2][slots] range (-1: not known), intensity
    std::size_t known = 0;     // rays
    std::size_t returned = 0;  // known ones
  };
  /// Weighted mean that forgets: about the last 20 values count.
  struct RunningMean {
    double sum = 0.0;
    double weight = 0.0;
    void add(double value);
    [[nodiscard]] double value() const;
  };

  const SensorRays& camera_rays(const std::string& name);
  std::shared_ptr<const ImageTruth> image_truth(std::size_t index, const SensorRays& rays);
  std::shared_ptr<const SweepTruth> sweep_truth(std::size_t index);
  MovingReturns moving_returns(const SweepFrame& frame, const Sweep& sweep) const;
  std::vector<bool> hidden_pixels(const ImageFrame& frame) const;
  void step_camera(double progress);
  void step_lidar(double progress);

  const Log& log_;
  Scene scene_;
  MovingSpace moving_;
  TrainOptions options_;
  Device device_;
  Renderer renderer_;
  ParticleBuffers camera_, lidar_;
  RealBuffer camera_grads_, lidar_grads_;
  AdamStage camera_adam_, lidar_adam_;
  FrameOrder images_, sweeps_;
  std::map<std::string, Camera> models_;  // scaled, by name
  std::map<std::string, std::unique_ptr<SensorRays>> camera_rays_;
  LruCache<ImageTruth> image_cache_;
  LruCache<SweepTruth> sweep_cache_;
  RunningMean square_, distance_, right_;
  TrainStatus status_;
};

}  // namespace simuli

#pragma once
// Fits the two particle sets of a scene to a log: one image per iteration, a sweep every few, Adam on each
// set.
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "host/render/regularize.hpp"
#include "host/render/renderer.hpp"
#include "host/scene/scene.hpp"
#include "io/log.hpp"
#include "optim/moving_space.hpp"
#include "optim/schedule.hpp"
#include "optim/train_options.hpp"
#include "optim/trained_look.hpp"
#include "optim/trained_set.hpp"
#include "optim/truth.hpp"

namespace simuli {

/// Mean that forgets: about the last 20 values count.
struct RunningMean {
  double sum = 0.0;
  double weight = 0.0;
  void add(double value);
  /// NaN before the first value.
  [[nodiscard]] double value() const;
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

  Trainer(const Trainer&) = delete;
  Trainer& operator=(const Trainer&) = delete;

 private:
  /// Error{kNumeric} naming the frame's file unless the loss is a finite number.
  static void need_finite(double loss, const std::string& file);
  void regularize(TrainedSet& set, const ParticleWeights& weights);
  void step_camera(double progress);  // trainer_camera.cpp
  void step_lidar(double progress);   // trainer_lidar.cpp

  const Log& log_;
  Scene scene_;
  TrainOptions options_;
  Device device_;
  Renderer renderer_;
  TruthCache truth_;
  TrainedSet camera_, lidar_;
  TrainedLook look_;
  RegularizeStage regularize_;
  FrameOrder images_, sweeps_;
  RunningMean square_, distance_, right_;
  TrainStatus status_;
};

}  // namespace simuli

#pragma once
// Fits the two particle sets of a scene to a log: one image per iteration, a sweep every few, Adam on each
// set.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "host/render/scene/renderer.hpp"
#include "host/render/train/regularize.hpp"
#include "host/scene/scene.hpp"
#include "io/log/log.hpp"
#include "optim/fixer/fixed_views.hpp"
#include "optim/init/moving_space.hpp"
#include "optim/length/length.hpp"
#include "optim/poses/sensor_offsets.hpp"
#include "optim/report/train_report.hpp"
#include "optim/state/state.hpp"
#include "optim/train/schedule.hpp"
#include "optim/train/structure.hpp"
#include "optim/train/trained_drop.hpp"
#include "optim/train/trained_look.hpp"
#include "optim/train/trained_set.hpp"
#include "optim/train/training_options.hpp"
#include "optim/train/truth.hpp"

namespace simuli {

/// Mean that forgets: about the last 20 values count.
struct RunningMean {
  double sum = 0.0;
  double weight = 0.0;
  void add(double value);
  /// NaN before the first value.
  [[nodiscard]] double value() const;
};

/// One training. The same device, build, log, scene and options give the same bits, unless max_seconds
/// stops it.
class Trainer {
 public:
  /// Error{kUsage} for options outside their range, Error{kInput} when the log has no frame to train on.
  /// `log` must outlive the trainer.
  /// `moving` (of the initialisation) is used when train.mask_moving.
  Trainer(const Device& device,
          const Log& log,
          Scene scene,
          const TrainingOptions& options,
          MovingSpace moving = {});

  /// One iteration: a step on the camera set, and on the LiDAR set when it is its turn; each only when it has
  /// frames and particles. Error{kInput} when a frame can't be read. What is not a finite number moves
  /// nothing and is counted (TrainReport): training goes on.
  void step();
  /// All iterations that are left; `on_step` is called after each.
  TrainReport run(const std::function<void(const TrainStatus&)>& on_step = {});

  /// Stores all that decides how this training goes on; atomic. `settings`: a line for each thing that must
  /// be the same for it to be the same training, but for the number of iterations.
  void save(const std::filesystem::path& file, const std::string& settings);
  /// Goes on where a trainer of the same log, start and options was saved: with the same bits, on the same
  /// device and build. This one may have more iterations: their rates then follow its own, longer schedule.
  /// Error{kInput} when the file is of another training, of more iterations, or not as it was written.
  void resume(const std::filesystem::path& file, const std::string& settings);
  /// Error{kInput} when the file is no checkpoint, or of other settings: what resume() would say, before the
  /// start has been made.
  static void need_settings(const std::filesystem::path& file,
                            const std::string& settings,
                            const TrainOptions& options);

  [[nodiscard]] const TrainStatus& status() const { return status_; }
  /// What has been learned of where sensors sit; empty unless train.poses ask for it.
  [[nodiscard]] const SensorOffsets& sensor_offsets() const { return offsets_; }
  /// A LiDAR of the log, with the range biases of its rows that have been found.
  [[nodiscard]] const LidarModel& lidar(const std::string& name) const { return truth_.lidar(name); }
  /// The scene as trained so far, without particles that are not finite.
  [[nodiscard]] Scene scene() const;

  Trainer(const Trainer&) = delete;
  Trainer& operator=(const Trainer&) = delete;

 private:
  /// What a step on a set has of its frame, and of its own.
  struct Turn {
    Pass& pass;
    TrainedSet& set;
    SetNumber number;
    const LearningRates& rates;
    const ParticleWeights& weights;
    const std::string& sensor;
    double time_start_s, time_end_s;
    double progress;
    bool errors;  // are collected
  };
  void step_camera(double progress);
  void step_lidar(double progress);
  /// The camera set along a sweep's rays.
  void step_depth(double progress);
  /// Has pictures from beside the path mended, and the camera set learn from one of them.
  void mend();
  void step_mended(const FixedView& mended, double progress);
  /// From the loss of the pass to the set's step: what both sets do, in its order.
  void descend(const Turn& turn);
  void regularize(TrainedSet& set, const ParticleWeights& weights);
  [[nodiscard]] bool prunes(int iteration) const;
  /// Takes out what no training sweep needs of the LiDAR set, and corrects the rows' ranges.
  void look_over_sweeps();
  void step_pose(const Turn& turn);
  /// What the frame says of the actors: their poses, behind the particles' own step.
  void step_actors(const Turn& turn);
  template <class Frame>
  [[nodiscard]] View view(const Frame& frame, const std::string& sensor) const;
  /// Whether the loss of a frame is a finite number; counts it when it is not.
  bool is_sound(double loss);
  StateList state(const std::string& settings);
  /// Sees what its end says, when a stage is done of a training that decides how long it goes on.
  void end_stage();

  const Log& log_;
  Scene scene_;
  TrainOptions options_;
  Device device_;
  Renderer renderer_;
  TruthCache truth_;
  TrainedSet camera_, lidar_;
  TrainedLook look_;
  TrainedDrop drop_;
  Structure structure_;
  RegularizeStage regularize_;
  FrameOrder images_, sweeps_;
  TrainLength length_;
  SensorOffsets offsets_;  // of the sensors whose poses are learned
  FixedViews mended_;
  RunningMean square_, distance_, right_;
  TrainStatus status_;
  std::uint32_t unsound_losses_ = 0;
  std::uint64_t pruned_ = 0;
};

}  // namespace simuli

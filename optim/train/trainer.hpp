#pragma once
// Fits the two particle sets of a scene to a log: one image per iteration, a sweep every few, Adam on each
// set.
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/core/scene/scene.hpp"
#include "io/log/log.hpp"
#include "optim/train/ranks/ranks.hpp"
#include "optim/train/train_report.hpp"
#include "optim/train/loss_terms/loss_term.hpp"
#include "optim/train/shards.hpp"
#include "optim/train/trainer_state.hpp"
#include "optim/train/training_options.hpp"

namespace simuli {

/// One training. The same device, build, log, scene and options give the same bits, unless max_seconds
/// stops it, however many ranks share it.
class Trainer {
 public:
  /// Error{kUsage} for options outside their range, Error{kInput} when the log has no frame to train on.
  /// `log` must outlive the trainer.
  /// `ranks` must outlive it, too: all of them have a trainer of the same arguments, and call it alike.
  Trainer(const Device& device,
          const Log& log,
          Scene scene,
          const TrainingOptions& options,
          Ranks& ranks = one_rank());

  /// One iteration: a step of each loss_term whose turn it is (loss_terms/loss_term.hpp). Error{kInput} when a frame
  /// can't be read. What is not a finite number moves nothing and is counted (TrainReport): training goes on.
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
                            const TrainOptions& options) {
    TrainerState::need_settings(file, settings, options);
  }

  /// RanksDiffer when a rank's state has other bits than rank 0's.
  void need_one_state(const std::string& settings);

  [[nodiscard]] const TrainStatus& status() const { return state_.status; }
  /// A LiDAR of the log, with the range biases of its rows that have been found.
  [[nodiscard]] const LidarModel& lidar(const std::string& name) const { return state_.truth.lidar(name); }
  /// The scene as trained so far, without particles that are not finite.
  [[nodiscard]] Scene scene() const;

  Trainer(const Trainer&) = delete;
  Trainer& operator=(const Trainer&) = delete;

 private:
  /// Has pictures from beside the path repaired, when it is time for that. Where it can't, `on_step` is called once
  /// more: whoever ended the program can store the state, which is that of before.
  void repair(const std::function<void(const TrainStatus&)>& on_step);
  /// What the next iterations take first is read meanwhile.
  void read_ahead();
  /// Sees what its end says, when a stage is done of a training that decides how long it goes on.
  void end_stage();

  Ranks& ranks_;
  TrainerState state_;
  Shards shards_;
  std::vector<std::unique_ptr<LossTerm>> loss_terms_;  // in the order of their steps
};

}  // namespace simuli

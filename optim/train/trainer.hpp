#pragma once
// Fits the two Gaussian sets of a scene to a log: one picture per iteration, a sweep every few iterations, one
// Adam optimiser per set.
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

/// A training. The same device, build, log, scene and options give the same bits for any number of ranks,
/// unless max_seconds stops it.
class Trainer {
 public:
  /// Throws Error{kUsage} for options outside their range, Error{kInput} when the log has no training frame.
  /// `log` and `ranks` must outlive the trainer; each rank constructs a trainer with the same arguments and
  /// makes the same calls.
  Trainer(const Device& device,
          const Log& log,
          Scene scene,
          const TrainingOptions& options,
          Ranks& ranks = one_rank());

  /// Runs one iteration: a step of each loss term that is due (loss_terms/loss_term.hpp). Throws Error{kInput}
  /// when a frame cannot be read. Non-finite gradients change nothing and are counted (TrainReport).
  void step();
  /// Runs the remaining iterations; calls `on_step` after each.
  TrainReport run(const std::function<void(const TrainStatus&)>& on_step = {});

  /// Saves the complete training state, atomically. `settings`: one line for each property that must match on
  /// resume, except the number of iterations.
  void save(const std::filesystem::path& file, const std::string& settings);
  /// Restores the state of a trainer with the same log, initialisation and options: continues with the same
  /// bits on the same device and build. This trainer may have more iterations: rates then follow its own,
  /// longer schedule. Throws Error{kInput} for a file of another training, of more iterations, or a damaged
  /// file.
  void resume(const std::filesystem::path& file, const std::string& settings);
  /// Throws Error{kInput} when the file is no checkpoint or has other settings, as resume() would, before
  /// initialisation.
  static void need_settings(const std::filesystem::path& file,
                            const std::string& settings,
                            const TrainOptions& options) {
    TrainerState::need_settings(file, settings, options);
  }

  /// Throws RanksDiffer when a rank's state has other bits than rank 0's.
  void need_one_state(const std::string& settings);

  [[nodiscard]] const TrainStatus& status() const { return state_.status; }
  /// A LiDAR of the log, with its learned range biases by row.
  [[nodiscard]] const LidarModel& lidar(const std::string& name) const { return state_.truth.lidar(name); }
  /// Returns the current scene without non-finite particles.
  [[nodiscard]] Scene scene() const;

  Trainer(const Trainer&) = delete;
  Trainer& operator=(const Trainer&) = delete;

 private:
  /// Has off-trajectory pictures repaired when due. On failure it calls `on_step` once more, so that the caller
  /// can save the state before it.
  void repair(const std::function<void(const TrainStatus&)>& on_step);
  /// Requests the frames of the next iterations, which are read in the background.
  void read_ahead();
  /// Ends the current stage of an automatic training when due.
  void end_stage();

  Ranks& ranks_;
  TrainerState state_;
  Shards shards_;
  std::vector<std::unique_ptr<LossTerm>> loss_terms_;  // in the order of their steps
};

}  // namespace simuli

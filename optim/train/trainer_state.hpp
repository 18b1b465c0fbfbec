#pragma once
// All state that training steps read and change.
#include <cstdint>
#include <string>

#include "host/core/scene/scene.hpp"
#include "host/device/render/scene/renderer.hpp"
#include "io/log/log.hpp"
#include "optim/complete/fixed_views.hpp"
#include "optim/train/length.hpp"
#include "optim/train/train_report.hpp"
#include "optim/base/state.hpp"
#include "optim/train/schedule.hpp"
#include "optim/train/structure.hpp"
#include "optim/train/trained_drop.hpp"
#include "optim/train/trained_appearance.hpp"
#include "optim/train/trained_set.hpp"
#include "optim/train/training_options.hpp"
#include "optim/train/truth.hpp"

namespace simuli {

/// Exponential running mean over about the last 20 values.
struct RunningMean {
  double sum = 0.0;
  double weight = 0.0;
  void add(double value);
  /// NaN before the first value.
  [[nodiscard]] double value() const;
};

struct TrainerState {
  /// Arguments as Trainer's.
  TrainerState(const Device& device, const Log& log, Scene scene, const TrainingOptions& options);
  TrainerState(const TrainerState&) = delete;
  TrainerState& operator=(const TrainerState&) = delete;

  /// Returns the checkpoint contents. `settings` as in Trainer::save().
  [[nodiscard]] StateList list(const std::string& settings);
  /// Throws Error{kInput} when the options cannot continue from the state list in `file`.
  static void need_settings(const std::filesystem::path& file,
                            const std::string& settings,
                            const TrainOptions& options);

  /// Returns the learning rates of a set in the current stage.
  [[nodiscard]] LearningRates rates(SetNumber number) const;

  const Log& log;
  Scene scene;
  double actor_margin_m = 0.0;
  double sky_from_m;  // from this distance on particles count as sky
  /// The rates apply to steps of options.shards frames; lidar_every counts sweeps of any LiDAR; iterations as
  /// planned so far.
  TrainOptions options;
  std::uint64_t seed;
  Device device;
  Renderer renderer;
  TruthCache truth;
  TrainedSet camera, lidar;
  TrainedAppearance appearance;
  TrainedDrop drop;
  FrameOrder images, sweeps;
  Structure structure;
  FixedViews repaired;
  TrainLength length;
  RunningMean square, distance, right;
  TrainStatus status;
  std::uint32_t unsound_losses = 0;
  std::uint64_t pruned = 0;
};

}  // namespace simuli

#pragma once
// Loss terms of a training. Each renders one kind of frame, computes its loss and takes an optimiser step on
// one set.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "optim/train/shards.hpp"
#include "optim/train/trainer_state.hpp"

namespace simuli {

class LossTerm {
 public:
  virtual ~LossTerm() = default;
  LossTerm(const LossTerm&) = delete;
  LossTerm& operator=(const LossTerm&) = delete;

  /// Whether the current iteration (TrainerState::status) has a step of this term.
  [[nodiscard]] virtual bool is_due() const = 0;
  /// Takes one step on a frame of each shard; `progress` in [0, 1] of the training.
  void step(Shards& shards, double progress);

 protected:
  /// `state` must outlive this object.
  LossTerm(TrainerState& state, SetNumber number);

  /// Renders the frame of a shard and stores its gradients in the set; `error` as in Shards::Show.
  [[nodiscard]] virtual RenderedShard show(std::size_t shard, RealBuffer& error) = 0;
  /// Updates the particles and this term's other parameters with the gradients of all shards.
  virtual void learn(const std::vector<ShardPart>& parts, Shards& shards);
  /// Records the losses of a shard, all finite, in the training's status.
  virtual void note(std::size_t /*shard*/, std::span<const double> /*losses*/) {}
  /// Whether this step accumulates per-particle reconstruction errors, which place new particles.
  [[nodiscard]] virtual bool collects_errors() const { return false; }

  [[nodiscard]] std::size_t shard_count() const {
    return static_cast<std::size_t>(state_.options.shards.count);
  }
  /// Returns the frame of a shard in step `turn` (from 0) of this kind of frame.
  [[nodiscard]] std::size_t frame_of(FrameOrder& order, int turn, std::size_t shard) const;
  /// Backpropagates the pass's loss to the particles alone.
  [[nodiscard]] RenderedShard particles_alone(Pass pass, double loss);
  /// Takes an optimiser step on the particles visible in any shard.
  void step_particles(const Shards& shards);

  // Recording times of a frame, for steps on poses and shapes of actors.
  struct FrameTimes {
    double start_s = 0.0, end_s = 0.0;
  };
  /// Backpropagates the pass's loss to the set and its actors; adds reconstruction errors to `error`.
  void differentiate(Pass& pass, ShardPart& part, RealBuffer& error);
  /// Takes a step on the set, and on its actors for each shard; `times` of the shards' frames.
  void step_set(const std::vector<ShardPart>& parts,
                const std::vector<FrameTimes>& times,
                const Shards& shards);

  TrainerState& state_;
  TrainedSet& set_;
  SetNumber number_;
  double progress_ = 0.0;  // of the current step
  bool errors_ = false;  // whether the current step accumulates reconstruction errors
};

/// Picture loss of the camera set on a recorded picture, in each iteration.
[[nodiscard]] std::unique_ptr<LossTerm> picture_loss_term(TrainerState& state);
/// Picture loss of the camera set on an off-trajectory picture repaired by an external program
/// (docs/FIXERS.md).
[[nodiscard]] std::unique_ptr<LossTerm> repaired_loss_term(TrainerState& state);
/// Picture loss of the camera set in off-trajectory views: the colours of the LiDAR set's surfaces from a
/// recorded picture.
[[nodiscard]] std::unique_ptr<LossTerm> off_trajectory_loss_term(TrainerState& state);
/// Depth loss of the camera set along the rays of a sweep.
[[nodiscard]] std::unique_ptr<LossTerm> depth_loss_term(TrainerState& state);
/// Distance, intensity and ray-drop losses of the LiDAR set on a recorded sweep.
[[nodiscard]] std::unique_ptr<LossTerm> sweep_loss_term(TrainerState& state);

}  // namespace simuli

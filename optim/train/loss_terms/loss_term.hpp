#pragma once
// What a training learns from: kinds of frames, on each of which one of its sets takes steps.
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

  /// Whether this iteration (TrainerState::status) has a step of it.
  [[nodiscard]] virtual bool is_due() const = 0;
  /// One step on a frame of each shard; `progress` in [0, 1] of the training.
  void step(Shards& shards, double progress);

 protected:
  /// `state` must outlive it.
  LossTerm(TrainerState& state, SetNumber number);

  /// Renders the frame of a shard and leaves its gradients with the set; `error` as Shards::Show has it.
  [[nodiscard]] virtual RenderedShard show(std::size_t shard, RealBuffer& error) = 0;
  /// Moves by what all shards say: the particles, and what more it is that the loss_term teaches.
  virtual void learn(const std::vector<ShardPart>& parts, Shards& shards);
  /// What the losses of a shard say of the training; they are finite.
  virtual void note(std::size_t /*shard*/, std::span<const double> /*losses*/) {}
  /// Whether frames tell errors in this step, for where particles are missing.
  [[nodiscard]] virtual bool collects_errors() const { return false; }

  [[nodiscard]] std::size_t shard_count() const {
    return static_cast<std::size_t>(state_.options.shards.count);
  }
  /// The frame of a shard in turn `turn` (from 0) of a kind of frames.
  [[nodiscard]] std::size_t frame_of(FrameOrder& order, int turn, std::size_t shard) const;
  /// Of frames that teach the particles alone: from the loss of the pass to their gradients.
  [[nodiscard]] RenderedShard particles_alone(Pass pass, double loss);
  /// One step on the particles that the shards show.
  void step_particles(const Shards& shards);

  // Of frames that tell all that a set learns, as the log has recorded them.
  struct FrameTimes {
    double start_s = 0.0, end_s = 0.0;
  };
  /// From the loss of the pass to the gradients of the set and of its actors, and errors, added to `error`.
  void differentiate(Pass& pass, ShardPart& part, RealBuffer& error);
  /// The step of the set, and of its actors by each of the shards; `times` of their frames.
  void step_set(const std::vector<ShardPart>& parts,
                const std::vector<FrameTimes>& times,
                const Shards& shards);

  TrainerState& state_;
  TrainedSet& set_;
  SetNumber number_;
  double progress_ = 0.0;  // of the step being taken
  bool errors_ = false;    // are collected in it
};

/// A recorded picture for the camera set, each iteration.
[[nodiscard]] std::unique_ptr<LossTerm> picture_loss_term(TrainerState& state);
/// A picture from beside the path that a program has repaired (docs/FIXERS.md), for the camera set.
[[nodiscard]] std::unique_ptr<LossTerm> repaired_loss_term(TrainerState& state);
/// The camera set as it is seen from beside a picture: what the picture shows there of the LiDAR set's
/// surfaces.
[[nodiscard]] std::unique_ptr<LossTerm> off_trajectory_loss_term(TrainerState& state);
/// The camera set along a sweep's rays.
[[nodiscard]] std::unique_ptr<LossTerm> depth_loss_term(TrainerState& state);
/// A recorded sweep for the LiDAR set.
[[nodiscard]] std::unique_ptr<LossTerm> sweep_loss_term(TrainerState& state);

}  // namespace simuli

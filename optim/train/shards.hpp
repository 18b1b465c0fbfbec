#pragma once
// The frames of one step, and who computes them. Each frame is a shard, computed as a whole by one rank. What
// all frames share (particles, environment) takes one step by the mean of their gradients, added in the order
// of shards; what belongs to one of them (colour grids, poses of actors at its time) a step for each, in that
// order. One shard is its own mean, and nothing is added up.
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "host/device/render/scene/pass.hpp"
#include "host/device/render/train/shard_sum.hpp"
#include "optim/train/ranks/ranks.hpp"
#include "optim/train/trained_drop.hpp"
#include "optim/train/trained_set.hpp"

namespace simuli {

/// What a shard's frame says of all that training moves but the particles, whose gradients Shards adds up.
struct ShardPart {
  std::vector<double> losses = {};  // the first is the one that was minimised
  std::vector<ActorPoseGradient> poses = {};
  std::vector<DeformationGradient> shapes = {};
  // Gradients; empty where one shard is all: they stand where they are.
  std::vector<float> grid = {}, environment = {};
  std::vector<TrainedDrop::Function> drop = {};  // what a sweep teaches; one, or none

  void put(RankWriter& writer) const;
  [[nodiscard]] static ShardPart of(RankReader& reader);
};

/// A frame that was rendered, whose gradients stand with its set.
struct RenderedShard {
  Pass pass;
  ShardPart part;
};

class Shards {
 public:
  /// `ranks` must outlive it: no more than shards.
  Shards(const Device& device, std::size_t count, Ranks& ranks);

  [[nodiscard]] std::size_t count() const { return count_; }
  /// Adds up gradients, where there are several shards; else null.
  [[nodiscard]] ShardSum* sum() { return sum_ ? &*sum_ : nullptr; }

  /// Renders a shard's frame, leaves its gradients with the set, and adds errors to `error`.
  using Show = std::function<RenderedShard(std::size_t shard, RealBuffer& error)>;
  /// This rank's shards by `show`. The parts of all shards, in their order, which every rank has then, as
  /// grads() and keys(); with `errors` the set has theirs.
  [[nodiscard]] std::vector<ShardPart> run(TrainedSet& set, bool errors, const Show& show);

  /// Of the last run(): the mean of the gradients, and as a frame's keys what any of the shards shows. They
  /// stand until the renderer's next frame.
  [[nodiscard]] const RealBuffer& grads() const { return *grads_; }
  [[nodiscard]] const Buffer<std::uint32_t>& keys() const { return *keys_; }
  [[nodiscard]] std::uint64_t gathered_bytes() const { return gathered_bytes_; }

 private:
  [[nodiscard]] std::vector<ShardPart> gather(const std::vector<ShardPart>& own);

  std::size_t count_;
  Ranks& ranks_;
  std::optional<ShardSum> sum_;
  const RealBuffer* grads_ = nullptr;
  const Buffer<std::uint32_t>* keys_ = nullptr;
  Ranks::Bytes message_;  // to other ranks; its memory is used again
  std::uint64_t gathered_bytes_ = 0;
};

}  // namespace simuli

#pragma once
// The frames of one step and the ranks that compute them. Each frame is a shard, computed by one rank.
// Parameters common to all frames (particles, environment) take one step with the mean of the gradients, summed
// in the order of shards; parameters of single frames (colour grids, actor poses at its time) take one step per
// shard, in that order. A single shard needs no sum.
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

/// Results of a shard's frame except the particle gradients, which Shards sums.
struct ShardPart {
  std::vector<double> losses = {};  // the first is the minimised loss
  std::vector<ActorPoseGradient> poses = {};
  std::vector<DeformationGradient> shapes = {};
  // Gradients; empty with a single shard, whose gradients stay on the device.
  std::vector<float> grid = {}, environment = {};
  std::vector<TrainedDrop::Function> drop = {};  // ray-drop functions trained by a sweep: one or none

  void put(RankWriter& writer) const;
  [[nodiscard]] static ShardPart of(RankReader& reader);
};

/// A rendered frame whose gradients are stored in its set.
struct RenderedShard {
  Pass pass;
  ShardPart part;
};

class Shards {
 public:
  /// At most as many ranks as shards; `ranks` must outlive this object.
  Shards(const Device& device, std::size_t count, Ranks& ranks);

  [[nodiscard]] std::size_t count() const { return count_; }
  /// Sums gradients of several shards; null with one.
  [[nodiscard]] ShardSum* sum() { return sum_ ? &*sum_ : nullptr; }

  /// Renders a shard's frame, stores its gradients in the set, and adds reconstruction errors to `error`.
  using Show = std::function<RenderedShard(std::size_t shard, RealBuffer& error)>;
  /// Runs `show` for the shards of this rank. Every rank then has the parts of all shards in order, their
  /// grads() and keys(); with `errors` the set has their summed errors.
  [[nodiscard]] std::vector<ShardPart> run(TrainedSet& set, bool errors, const Show& show);

  /// Results of the last run(): the mean gradients, and the keys of particles visible in any shard. Valid until
  /// the renderer's next frame.
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
  Ranks::Bytes message_;  // to other ranks; its memory is reused
  std::uint64_t gathered_bytes_ = 0;
};

}  // namespace simuli

// Losses on recorded sweeps.
#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "optim/base/frames.hpp"
#include "optim/train/loss_terms/loss_term.hpp"

namespace simuli {
namespace {

class SweepLossTerm final : public LossTerm {
 public:
  explicit SweepLossTerm(TrainerState& state) : LossTerm(state, kLidarSet) {}

  [[nodiscard]] bool is_due() const override {
    return state_.status.iteration % state_.options.lidar_every == 0 && !state_.sweeps.empty() &&
           set_.particles.count > 0;
  }

 private:
  [[nodiscard]] std::size_t sweep(std::size_t shard) const {
    return frame_of(state_.sweeps, state_.status.iteration / state_.options.lidar_every, shard);
  }
  [[nodiscard]] bool collects_errors() const override {
    return state_.structure.collects_errors(number_, state_.status.iteration);
  }
  [[nodiscard]] RenderedShard show(std::size_t shard, RealBuffer& error) override;
  void learn(const std::vector<ShardPart>& parts, Shards& shards) override;
  void note(std::size_t shard, std::span<const double> losses) override;
};

RenderedShard SweepLossTerm::show(std::size_t shard, RealBuffer& error) {
  const std::size_t index = sweep(shard);
  const SweepFrame& frame = state_.log.sweeps[index];
  const auto truth = state_.truth.sweep(index);
  View view = view_of(state_.log, state_.scene, frame);
  view.drop = state_.drop.of(frame.lidar);
  Pass pass = state_.renderer.render(set_.particles, truth->truth.rays(), view);
  const double rays = std::max(1.0, static_cast<double>(truth->known));
  // A sweep without returns has no distance loss: its sums are zero.
  const double returned = std::max(1.0, static_cast<double>(truth->returned));
  const LidarWeights& w = state_.options.weights;
  ShardPart part;
  const LidarLoss loss = state_.drop.learn(pass,
                                           truth->truth,
                                           index,
                                           frame.lidar,
                                           {w.distance / returned, w.intensity / returned, w.drop / rays},
                                           progress_,
                                           part.drop);
  if (errors_) {
    state_.structure.errors().beam_error(pass.frame(),
                                         pass.buffers().rays,
                                         pass.buffers().blended,
                                         truth->truth.slots(),
                                         {w.distance, w.intensity, w.drop},
                                         pass.ray_error());
  }
  part.losses = {
      loss.distance_m + loss.intensity + loss.entropy,
      loss.distance_m / returned,
      (w.distance * loss.distance_m + w.intensity * loss.intensity) / returned + w.drop * loss.entropy / rays,
      1.0 - loss.wrong / rays};
  differentiate(pass, part, error);
  return {std::move(pass), std::move(part)};
}

void SweepLossTerm::learn(const std::vector<ShardPart>& parts, Shards& shards) {
  std::vector<FrameTimes> times;
  std::map<std::string, std::vector<TrainedDrop::Function>> taught;
  for (std::size_t shard = 0; shard < parts.size(); ++shard) {
    const SweepFrame& frame = state_.log.sweeps[sweep(shard)];
    times.push_back({frame.time_start_s, frame.time_end_s});
    auto& functions = taught[frame.lidar];
    functions.insert(functions.end(), parts[shard].drop.begin(), parts[shard].drop.end());
  }
  for (const auto& [lidar, functions] : taught) state_.drop.take(lidar, functions);
  step_set(parts, times, shards);
}

void SweepLossTerm::note(std::size_t shard, std::span<const double> losses) {
  state_.distance.add(losses[1]);
  state_.length.add_sweep(sweep(shard), losses[2]);
  state_.right.add(losses[3]);
  state_.status.distance_m = state_.distance.value();
  state_.status.drop_accuracy = state_.right.value();
}

}  // namespace

std::unique_ptr<LossTerm> sweep_loss_term(TrainerState& state) { return std::make_unique<SweepLossTerm>(state); }

}  // namespace simuli

#include "optim/train/loss_terms/loss_term.hpp"

#include <cmath>
#include <utility>

namespace simuli {

LossTerm::LossTerm(TrainerState& state, SetNumber number)
    : state_(state), set_(number == kCameraSet ? state.camera : state.lidar), number_(number) {}

void LossTerm::step(Shards& shards, double progress) {
  progress_ = progress;
  errors_ = collects_errors();
  const std::vector<ShardPart> parts =
      shards.run(set_, errors_, [this](std::size_t shard, RealBuffer& error) { return show(shard, error); });
  learn(parts, shards);
  for (std::size_t shard = 0; shard < parts.size(); ++shard) {
    const std::vector<double>& losses = parts[shard].losses;
    if (std::isfinite(losses.at(0))) {
      note(shard, losses);
    } else {
      ++state_.unsound_losses;
    }
  }
}

void LossTerm::learn(const std::vector<ShardPart>& /*parts*/, Shards& shards) { step_particles(shards); }

std::size_t LossTerm::frame_of(FrameOrder& order, int turn, std::size_t shard) const {
  return order.at(static_cast<std::uint64_t>(turn) * shard_count() + shard);
}

RenderedShard LossTerm::particles_alone(Pass pass, double loss) {
  pass.backward(set_.particles, set_.grads);
  return {std::move(pass), {.losses = {loss}}};
}

void LossTerm::step_particles(const Shards& shards) {
  const int degree = set_.particles.sh_degree;
  const double epsilon = number_ == kCameraSet ? state_.appearance.harmonics_epsilon(set_.particles.count) : 0.0;
  set_.adam.run(set_.particles,
                shards.grads(),
                shards.keys(),
                {row_rates(state_.rates(number_), degree, progress_), row_epsilons(degree, epsilon)});
}

void LossTerm::differentiate(Pass& pass, ShardPart& part, RealBuffer& error) {
  pass.backward(set_.particles, set_.grads, {.errors = errors_});
  if (errors_) state_.structure.errors().accumulate(pass.frame(), pass.buffers(), pass.gradients(), error);
  SetHook* const hook = state_.structure.hook();
  if (hook != nullptr && number_ == kCameraSet) hook->add_gradients(pass, state_.status.iteration);
  if (set_.particles.actors == 0) return;
  if (set_.poses.learns()) part.poses = pass.pose_gradients(set_.particles);
  if (set_.shapes.learns()) part.shapes = pass.deformation_gradients();
}

void LossTerm::step_set(const std::vector<ShardPart>& parts,
                      const std::vector<FrameTimes>& times,
                      const Shards& shards) {
  const int iteration = state_.status.iteration;
  SetHook* const hook = state_.structure.hook();
  if (hook != nullptr && number_ == kCameraSet && parts.size() > 1) hook->finish_shards(shards.keys(), iteration);
  step_particles(shards);
  state_.structure.jitter(set_, number_, state_.rates(number_), shards.keys(), iteration, progress_);
  if (set_.particles.actors == 0) return;
  state_.renderer.confine(set_.particles, state_.scene.actors, state_.actor_margin_m);
  for (std::size_t i = 0; i < parts.size() && set_.poses.learns(); ++i) {
    set_.poses.step(state_.scene.actors, parts[i].poses, times[i].start_s, times[i].end_s, progress_);
  }
  for (std::size_t i = 0; i < parts.size() && set_.shapes.learns(); ++i) {
    set_.shapes.step(state_.scene.actors, parts[i].shapes, times[i].start_s, times[i].end_s, progress_);
  }
}

}  // namespace simuli

// Picture loss on recorded pictures.
#include <algorithm>
#include <cmath>
#include <utility>

#include "optim/base/frames.hpp"
#include "optim/train/loss_terms/loss_term.hpp"

namespace simuli {
namespace {

class PictureLossTerm final : public LossTerm {
 public:
  explicit PictureLossTerm(TrainerState& state) : LossTerm(state, kCameraSet) {}

  [[nodiscard]] bool is_due() const override { return !state_.images.empty() && set_.particles.count > 0; }

 private:
  [[nodiscard]] std::size_t picture(std::size_t shard) const {
    return frame_of(state_.images, state_.status.iteration, shard);
  }
  [[nodiscard]] bool collects_errors() const override {
    return state_.structure.collects_errors(number_, state_.status.iteration);
  }
  [[nodiscard]] RenderedShard show(std::size_t shard, RealBuffer& error) override;
  void learn(const std::vector<ShardPart>& parts, Shards& shards) override;
  void note(std::size_t shard, std::span<const double> losses) override;
};

RenderedShard PictureLossTerm::show(std::size_t shard, RealBuffer& error) {
  const std::size_t index = picture(shard);
  const auto truth = state_.truth.image(index);
  const ImageFrame& frame = state_.log.images[index];
  Pass pass = state_.renderer.render(state_.camera.particles,
                                     state_.truth.camera_rays(frame.camera),
                                     view_of(state_.log, state_.scene, frame),
                                     state_.appearance.environment());
  state_.appearance.grade(pass, index);
  const double values = 3.0 * std::max(1.0, static_cast<double>(truth->known));
  const ImageWeights& w = state_.options.image;
  const double sky = truth->truth.channels() == 4 ? 3.0 * w.sky / values : 0.0;
  const ImageLoss loss = pass.image_loss(
      truth->truth,
      {w.absolute / values, w.squared / values, w.dissimilarity / values, sky, state_.sky_from_m});
  if (errors_) {
    state_.structure.errors().pixel_error(
        pass.frame(), pass.buffers().rays, pass.picture(), truth->truth.slots(), pass.ray_error());
  }
  state_.appearance.backward(pass, index);
  ShardPart part;
  part.losses = {loss.absolute + loss.squared + loss.dissimilarity, loss.squared / values};
  if (shard_count() > 1) {
    TrainedAppearance::Gradients gradients = state_.appearance.gradients();
    part.grid = std::move(gradients.grid);
    part.environment = std::move(gradients.environment);
  }
  differentiate(pass, part, error);
  return {std::move(pass), std::move(part)};
}

void PictureLossTerm::learn(const std::vector<ShardPart>& parts, Shards& shards) {
  std::vector<TrainedAppearance::Shard> observations;
  std::vector<FrameTimes> times;
  for (std::size_t shard = 0; shard < parts.size(); ++shard) {
    const std::size_t index = picture(shard);
    observations.push_back({index, {parts[shard].grid, parts[shard].environment}});
    times.push_back({state_.log.images[index].time_start_s, state_.log.images[index].time_end_s});
  }
  const auto iteration = static_cast<std::uint64_t>(state_.status.iteration);
  state_.appearance.step(observations, iteration, state_.options.iterations, shards.sum());
  step_set(parts, times, shards);
}

void PictureLossTerm::note(std::size_t shard, std::span<const double> losses) {
  state_.square.add(losses[1]);
  state_.length.add_image(picture(shard), losses[1]);
  state_.status.psnr_db = -10.0 * std::log10(state_.square.value());
}

}  // namespace

std::unique_ptr<LossTerm> picture_loss_term(TrainerState& state) {
  return std::make_unique<PictureLossTerm>(state);
}

}  // namespace simuli

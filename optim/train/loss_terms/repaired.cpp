// Loss on off-trajectory pictures that an external program has repaired.
#include <utility>

#include "optim/train/loss_terms/loss_term.hpp"

namespace simuli {
namespace {

class RepairedLossTerm final : public LossTerm {
 public:
  explicit RepairedLossTerm(TrainerState& state) : LossTerm(state, kCameraSet) {}

  [[nodiscard]] bool is_due() const override {
    return set_.particles.count > 0 && state_.repaired.turn(state_.status.iteration) != nullptr;
  }

 private:
  [[nodiscard]] RenderedShard show(std::size_t shard, RealBuffer& error) override;
};

RenderedShard RepairedLossTerm::show(std::size_t /*shard*/, RealBuffer& /*error*/) {
  const FixedView& repaired = *state_.repaired.turn(state_.status.iteration);
  const SensorRays& rays = state_.truth.camera_rays(repaired.camera);
  Pass pass = state_.renderer.render(
      set_.particles, rays, view_of(state_.scene, repaired.shot, SetKind::kCamera), state_.appearance.environment());
  const double share = state_.repaired.weight() / (3.0 * static_cast<double>(repaired.known));
  const ImageWeights& w = state_.options.image;
  const ImageLoss loss = pass.image_loss(RayValues(rays, repaired.values, 3, "repaired picture"),
                                         {w.absolute * share, w.squared * share, w.dissimilarity * share});
  if (state_.appearance.environment() != nullptr) {
    RealBuffer texels(state_.device, "environment's share of a repaired picture", Precision::kFloat);
    pass.environment_backward(*state_.appearance.environment(), 0.0, texels);
  }
  return particles_alone(std::move(pass), loss.absolute + loss.squared + loss.dissimilarity);
}

}  // namespace

std::unique_ptr<LossTerm> repaired_loss_term(TrainerState& state) { return std::make_unique<RepairedLossTerm>(state); }

}  // namespace simuli

// Pictures from beside the path that a program of the user's has mended.
#include <utility>

#include "optim/train/lesson/lesson.hpp"

namespace simuli {
namespace {

class MendedLesson final : public Lesson {
 public:
  explicit MendedLesson(TrainerState& state) : Lesson(state, kCameraSet) {}

  [[nodiscard]] bool is_due() const override {
    return set_.particles.count > 0 && state_.mended.turn(state_.status.iteration) != nullptr;
  }

 private:
  [[nodiscard]] ShownShard show(std::size_t shard, RealBuffer& error) override;
};

ShownShard MendedLesson::show(std::size_t /*shard*/, RealBuffer& /*error*/) {
  const FixedView& mended = *state_.mended.turn(state_.status.iteration);
  const SensorRays& rays = state_.truth.camera_rays(mended.camera);
  Pass pass = state_.renderer.render(
      set_.particles, rays, view_of(state_.scene, mended.shot, SetKind::kCamera), state_.look.environment());
  const double share = state_.mended.weight() / (3.0 * static_cast<double>(mended.known));
  const ImageWeights& w = state_.options.image;
  const ImageLoss loss = pass.image_loss(RayValues(rays, mended.values, 3, "mended picture"),
                                         {w.absolute * share, w.squared * share, w.dissimilarity * share});
  if (state_.look.environment() != nullptr) {
    RealBuffer texels(state_.device, "environment's share of a mended picture", Precision::kFloat);
    pass.environment_backward(*state_.look.environment(), 0.0, texels);
  }
  return particles_alone(std::move(pass), loss.absolute + loss.squared + loss.dissimilarity);
}

}  // namespace

std::unique_ptr<Lesson> mended_lesson(TrainerState& state) { return std::make_unique<MendedLesson>(state); }

}  // namespace simuli

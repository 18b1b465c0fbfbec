// Off-trajectory loss: supervises the camera set in views where no picture was recorded.
#include <map>
#include <string>
#include <utility>

#include "host/core/base/splitmix.hpp"
#include "optim/base/frames.hpp"
#include "optim/train/loss_terms/loss_term.hpp"

namespace simuli {
namespace {

constexpr std::uint64_t kStream = 3;  // random stream

class OffTrajectoryLossTerm final : public LossTerm {
 public:
  explicit OffTrajectoryLossTerm(TrainerState& state)
      : LossTerm(state, kCameraSet), surfaces_(state.device, Precision::kFloat) {}

  [[nodiscard]] bool is_due() const override {
    const OffTrajectoryOptions& o = state_.options.off_trajectory;
    return o.weight > 0.0 && state_.status.iteration % OffTrajectoryOptions::kEvery == 0 &&
           !state_.images.empty() && set_.particles.count > 0 && state_.lidar.particles.count > 0;
  }

 private:
  [[nodiscard]] RenderedShard show(std::size_t shard, RealBuffer& error) override;

  SeenSurfaces surfaces_;  // surfaces seen by the recorded picture
  std::map<std::string, RayValues>
      shown_;  // by camera: colours of the recorded picture in the off-trajectory view
};

RenderedShard OffTrajectoryLossTerm::show(std::size_t shard, RealBuffer& /*error*/) {
  const std::size_t index = frame_of(state_.images, state_.status.iteration, shard);
  const ImageFrame& frame = state_.log.images[index];
  const SensorRays& rays = state_.truth.camera_rays(frame.camera);
  // Counter of off-trajectory pictures over all shards.
  const std::uint64_t picture = static_cast<std::uint64_t>(state_.status.iteration) * shard_count() + shard;
  const double left_m =
      state_.options.off_trajectory.reach_m * (2.0 * drawn(state_.seed, kStream, picture) - 1.0);
  const Shot shot =
      shot_of(state_.log, frame).shifted_left(state_.log.camera(frame.camera).rig_from_camera, left_m);
  const View there = view_of(state_.scene, shot, SetKind::kCamera);
  RayValues& shown = shown_.try_emplace(frame.camera, rays, 3, "off-trajectory picture").first->second;
  state_.renderer.render(state_.lidar.particles, rays, view_of(state_.log, state_.scene, frame))
      .keep_surfaces(surfaces_);
  state_.renderer.render(state_.lidar.particles, rays, there)
      .show_from(surfaces_, state_.truth.image(index)->truth, shown);

  Pass pass = state_.renderer.render(set_.particles, rays, there, state_.appearance.environment());
  state_.appearance.grade(pass, index);
  // Normalised by all pixels, because the number of pixels with a known colour stays on the device.
  const double share = state_.options.off_trajectory.weight / (3.0 * static_cast<double>(rays.grid().rays));
  const ImageWeights& w = state_.options.image;
  const ImageLoss loss =
      pass.image_loss(shown, {w.absolute * share, w.squared * share, w.dissimilarity * share});
  state_.appearance.backward(pass, index);
  return particles_alone(std::move(pass), loss.absolute + loss.squared + loss.dissimilarity);
}

}  // namespace

std::unique_ptr<LossTerm> off_trajectory_loss_term(TrainerState& state) {
  return std::make_unique<OffTrajectoryLossTerm>(state);
}

}  // namespace simuli

// The camera set from beside the path: pictures alone leave open what it looks like from where none was
// taken.
#include <map>
#include <string>
#include <utility>

#include "host/core/base/splitmix.hpp"
#include "optim/base/frames.hpp"
#include "optim/train/lesson/lesson.hpp"

namespace simuli {
namespace {

constexpr std::uint64_t kStream = 3;  // of numbers drawn

class BesideLesson final : public Lesson {
 public:
  explicit BesideLesson(TrainerState& state)
      : Lesson(state, kCameraSet), surfaces_(state.device, Precision::kFloat) {}

  [[nodiscard]] bool is_due() const override {
    const BesideOptions& o = state_.options.beside;
    return o.weight > 0.0 && state_.status.iteration % BesideOptions::kEvery == 0 && !state_.images.empty() &&
           set_.particles.count > 0 && state_.lidar.particles.count > 0;
  }

 private:
  [[nodiscard]] ShownShard show(std::size_t shard, RealBuffer& error) override;

  SeenSurfaces surfaces_;                   // of the picture
  std::map<std::string, RayValues> shown_;  // by camera: what the picture shows of those beside
};

ShownShard BesideLesson::show(std::size_t shard, RealBuffer& /*error*/) {
  const std::size_t index = frame_of(state_.images, state_.status.iteration, shard);
  const ImageFrame& frame = state_.log.images[index];
  const SensorRays& rays = state_.truth.camera_rays(frame.camera);
  // Of all such pictures.
  const std::uint64_t picture = static_cast<std::uint64_t>(state_.status.iteration) * shard_count() + shard;
  const double left_m = state_.options.beside.reach_m * (2.0 * drawn(state_.seed, kStream, picture) - 1.0);
  const Shot shot =
      shot_of(state_.log, frame).beside(state_.log.camera(frame.camera).rig_from_camera, left_m);
  const View there = view_of(state_.scene, shot, SetKind::kCamera);
  RayValues& shown = shown_.try_emplace(frame.camera, rays, 3, "picture from beside").first->second;
  state_.renderer.render(state_.lidar.particles, rays, view_of(state_.log, state_.scene, frame))
      .keep_surfaces(surfaces_);
  state_.renderer.render(state_.lidar.particles, rays, there)
      .show_from(surfaces_, state_.truth.image(index)->truth, shown);

  Pass pass = state_.renderer.render(set_.particles, rays, there, state_.look.environment());
  state_.look.grade(pass, index);
  // Of all pixels: how many are known only the device knows.
  const double share = state_.options.beside.weight / (3.0 * static_cast<double>(rays.grid().rays));
  const ImageWeights& w = state_.options.image;
  const ImageLoss loss =
      pass.image_loss(shown, {w.absolute * share, w.squared * share, w.dissimilarity * share});
  state_.look.backward(pass, index);
  return particles_alone(std::move(pass), loss.absolute + loss.squared + loss.dissimilarity);
}

}  // namespace

std::unique_ptr<Lesson> beside_lesson(TrainerState& state) { return std::make_unique<BesideLesson>(state); }

}  // namespace simuli

// The camera set along the LiDARs' rays: pictures alone leave open how far away what they show is.
#include <algorithm>
#include <utility>

#include "optim/base/frames.hpp"
#include "optim/train/lesson/lesson.hpp"

namespace simuli {
namespace {

class DepthLesson final : public Lesson {
 public:
  explicit DepthLesson(TrainerState& state) : Lesson(state, kCameraSet) {}

  [[nodiscard]] bool is_due() const override {
    const DepthOptions& o = state_.options.depth;
    return o.weight > 0.0 && state_.status.iteration % o.every == 0 && !state_.images.empty() &&
           !state_.sweeps.empty() && set_.particles.count > 0;
  }

 private:
  [[nodiscard]] ShownShard show(std::size_t shard, RealBuffer& error) override;
};

ShownShard DepthLesson::show(std::size_t shard, RealBuffer& /*error*/) {
  const DepthOptions& o = state_.options.depth;
  const std::size_t index = frame_of(state_.sweeps, state_.status.iteration / o.every, shard);
  const auto truth = state_.truth.sweep(index);
  Pass pass = state_.renderer.render(
      set_.particles, truth->truth.rays(), view_of(state_.log, state_.scene, state_.log.sweeps[index]));
  const double returned = std::max(1.0, static_cast<double>(truth->returned));
  const LidarLoss loss = pass.lidar_loss(truth->truth, {.distance = o.weight / returned});
  return particles_alone(std::move(pass), loss.distance_m);
}

}  // namespace

std::unique_ptr<Lesson> depth_lesson(TrainerState& state) { return std::make_unique<DepthLesson>(state); }

}  // namespace simuli

// Depth loss: supervises the camera set's distance along LiDAR rays, because pictures alone leave depth
// ambiguous.
#include <algorithm>
#include <utility>
#include <vector>

#include "io/log/sweep_file.hpp"
#include "optim/base/frames.hpp"
#include "optim/train/loss_terms/loss_term.hpp"

namespace simuli {
namespace {

class DepthLossTerm final : public LossTerm {
 public:
  explicit DepthLossTerm(TrainerState& state) : LossTerm(state, kCameraSet) {}

  [[nodiscard]] bool is_due() const override {
    const DepthOptions& o = state_.options.depth;
    return o.weight > 0.0 && state_.status.iteration % o.every == 0 && !state_.images.empty() &&
           !state_.sweeps.empty() && set_.particles.count > 0;
  }

 private:
  [[nodiscard]] RenderedShard show(std::size_t shard, RealBuffer& error) override;
};

/// Returns the rays of one of DepthOptions::kSectors sectors of a sweep: neighbouring columns, so that most
/// particles intersect none of them.
SensorRays sector_of(const SensorRays& rays, std::size_t columns, std::size_t sector) {
  std::vector<bool> inside(rays.grid().rays);
  for (std::size_t ray = 0; ray < inside.size(); ++ray) {
    inside[ray] = ray % columns * DepthOptions::kSectors / columns == sector;
  }
  return rays.requested(std::move(inside));
}

RenderedShard DepthLossTerm::show(std::size_t shard, RealBuffer& /*error*/) {
  const DepthOptions& o = state_.options.depth;
  const int turn = state_.status.iteration / o.every;
  const std::size_t index = frame_of(state_.sweeps, turn, shard);
  const SweepFrame& frame = state_.log.sweeps[index];
  const auto truth = state_.truth.sweep(index);
  // Successive uses of a sweep take its sectors in turn.
  const std::size_t epoch = (static_cast<std::size_t>(turn) * shard_count() + shard) / state_.sweeps.size();
  const SensorRays rays = sector_of(truth->truth.rays(),
                                    sweep_shape(state_.truth.lidar(frame.lidar)).columns,
                                    (epoch + index) % DepthOptions::kSectors);
  Pass pass = state_.renderer.render(set_.particles, rays, view_of(state_.log, state_.scene, frame));
  const double returned = std::max(1.0, static_cast<double>(truth->returned) / DepthOptions::kSectors);
  const LidarLoss loss = pass.lidar_loss(truth->truth, {.distance = o.weight / returned});
  return particles_alone(std::move(pass), loss.distance_m);
}

}  // namespace

std::unique_ptr<LossTerm> depth_loss_term(TrainerState& state) { return std::make_unique<DepthLossTerm>(state); }

}  // namespace simuli

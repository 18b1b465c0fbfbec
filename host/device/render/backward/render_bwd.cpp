// Launcher of "kernels/render_bwd_lanes.cl" or "kernels/render_bwd_groups.cl", after "kernels/slot_counts.cl"
// and, for rays in their own order, "kernels/replay_window.cl" and "kernels/replay_per_ray.cl".
#include <algorithm>
#include <vector>

#include "host/device/render/backward/backward_stages.hpp"

namespace simuli {
namespace {

/// Runs of tiles [first, last) whose lists have up to `most` entries in total; a tile with more is a run by
/// itself.
struct TileRun {
  std::uint32_t first = 0, end = 0;
  std::size_t places = 0;
};
std::vector<TileRun> tile_runs(const Binned& binned, std::uint32_t tiles, std::size_t most) {
  if (binned.pairs <= most) return {{0, tiles, binned.pairs}};
  const std::vector<std::uint32_t> first = binned.first.download();
  std::vector<TileRun> runs;
  for (std::uint32_t tile = 0; tile < tiles; ++tile) {
    const std::size_t places = first[tile + 1] - first[tile];
    if (runs.empty() || runs.back().places + places > most) runs.push_back({tile, tile, 0});
    runs.back().end = tile + 1;
    runs.back().places += places;
  }
  return runs;
}

}  // namespace

RenderBackwardStage::RenderBackwardStage(const Device& device, const Variant& variant)
    : device_(device),
      variant_(variant),
      scan_(device),
      slot_counts_(Program(device, "kernels/slot_counts.cl", BuildOptions()), "slot_counts") {
  const BuildOptions options = variant.build_options();
  if (variant.options.order != Order::kRange)
    replay_window_.emplace(Program(device, "kernels/replay_window.cl", options), "replay_window");
  if (variant.options.order == Order::kPerRay)
    replay_per_ray_.emplace(Program(device, "kernels/replay_per_ray.cl", options), "replay_per_ray");
}

Kernel& RenderBackwardStage::kernel(const BackwardExtras& extras) {
  std::optional<Kernel>& kernel = kernels_[extras.errors ? 1 : 0];
  if (!kernel) {
    BuildOptions options = variant_.build_options();
    options.define("ERRORS", extras.errors);
    const bool is_group = variant_.options.shape.work_items > 1;
    kernel.emplace(
        Program(
            device_, is_group ? "kernels/render_bwd_groups.cl" : "kernels/render_bwd_lanes.cl", options),
        "render_bwd");
  }
  return *kernel;
}

void RenderBackwardStage::replay(const shared::FrameParams& frame,
                                 const ParticleBuffers& particles,
                                 const RayBuffers& rays,
                                 const FrameBuffers& made,
                                 std::uint32_t tile_first,
                                 std::size_t items,
                                 GradientBuffers& gradients) {
  const auto launch = [&](Kernel& kernel) {
    kernel.run(items,
               static_cast<std::size_t>(variant_.options.shape.work_items),
               {{"frame", frame},
                {"tile_first", tile_first},
                made.constants,
                made.rays,
                rays,
                made.binned,
                made.projected,
                particles,
                made.blended,
                gradients});
  };
  launch(*replay_window_);
  if (replay_per_ray_) launch(*replay_per_ray_);
}

void RenderBackwardStage::run(const shared::FrameParams& frame,
                              const ParticleBuffers& particles,
                              const RayBuffers& rays,
                              const FrameBuffers& made,
                              const BackwardExtras& extras,
                              GradientBuffers& gradients) {
  const std::size_t pairs = made.binned.pairs;
  if (extras.errors) gradients.pair_error.reserve(pairs);
  gradients.grads.reserve(pairs * SIM_GRAD);
  gradients.slot_first.reserve(frame.particles);
  Kernel& blend_back = kernel(extras);
  slot_counts_.run_over(frame.particles, {{"n", frame.particles}, made.projected, gradients});
  scan_.run(gradients.slot_first, frame.particles, false);
  const auto work_items = static_cast<std::size_t>(variant_.options.shape.work_items);
  const std::uint32_t tiles = frame.tiles_x * frame.tiles_y;
  const bool by_ray = variant_.options.order != Order::kRange;
  const auto runs =
      by_ray ? tile_runs(made.binned, tiles, extras.replayed) : std::vector<TileRun>{{0, tiles, 0}};
  std::size_t most = 0;
  for (const TileRun& run : runs) most = std::max(most, run.places);
  gradients.replayed.reserve(std::size_t{2} * SIM_TILE_RAYS * most);
  if (by_ray)
    gradients.replayed_to.reserve(frame.slots / static_cast<std::size_t>(variant_.options.shape.lanes));
  for (const TileRun& run : runs) {
    const std::size_t items = (run.end - run.first) * work_items;
    if (by_ray) replay(frame, particles, rays, made, run.first, items, gradients);
    blend_back.run(items,
                   work_items,
                   {{"frame", frame},
                    {"tile_first", run.first},
                    made.constants,
                    made.rays,
                    rays,
                    made.binned,
                    made.projected,
                    made.blended,
                    gradients});
  }
}

}  // namespace simuli

// Launcher of "kernels/render_bwd.cl".
#include "host/render/backward/backward_stages.hpp"

namespace simuli {
namespace {

constexpr std::size_t kRenderLocalSize = 64;

}  // namespace

RenderBackwardStage::RenderBackwardStage(const Device& device, const Variant& variant)
    : device_(device), variant_(variant), scan_(device) {}

Kernel& RenderBackwardStage::kernel(const BackwardExtras& extras) {
  std::optional<Kernel>& kernel = kernels_[extras.errors ? 1 : 0][extras.ray_gradients ? 1 : 0];
  if (!kernel) {
    BuildOptions options = variant_.build_options();
    options.define("ERRORS", extras.errors).define("RAY_GRADIENTS", extras.ray_gradients);
    const Program program(device_, "kernels/render_bwd.cl", options);
    kernel.emplace(program, "render_bwd");
    slot_counts_.emplace(program, "slot_counts");
  }
  return *kernel;
}

void RenderBackwardStage::run(const shared::FrameParams& frame,
                              const RayBuffers& rays,
                              const FrameBuffers& made,
                              const BackwardExtras& extras,
                              GradientBuffers& gradients) {
  const std::size_t instances = made.binned.instances;
  if (extras.errors) gradients.instance_error.reserve(instances);
  if (extras.ray_gradients) {
    gradients.ray_grads.reserve((variant_.frame.origins ? 6U : 3U) * std::size_t{frame.slots});
  }
  gradients.grads.reserve(instances * SIM_GRAD);
  gradients.slot_first.reserve(frame.particles);
  Kernel& blend_back = kernel(extras);
  slot_counts_->run(round_up(frame.particles, kRenderLocalSize),
                    kRenderLocalSize,
                    {{"n", frame.particles}, made.projected, gradients});
  scan_.run(gradients.slot_first, frame.particles, false);
  const auto work_items = static_cast<std::size_t>(variant_.frame.shape.work_items);
  blend_back.run(std::size_t{frame.tiles_x} * frame.tiles_y * work_items,
                 work_items,
                 {{"frame", frame},
                  made.constants,
                  made.rays,
                  rays,
                  made.binned,
                  made.projected,
                  made.blended,
                  gradients});
}

}  // namespace simuli

// Launcher of "kernels/project_bwd.cl".
#include "host/device/render/backward/backward_stages.hpp"

namespace simuli {
ProjectBackwardStage::ProjectBackwardStage(const Device& device, const Variant& variant)
    : lanes_(variant.options.shape.lanes),
      actors_(variant.frame.actors),
      project_bwd_(Program(device, "kernels/project_bwd.cl", variant.build_options()), "project_bwd") {}

void ProjectBackwardStage::run(const shared::FrameParams& frame,
                               const ParticleBuffers& particles,
                               const FrameBuffers& made,
                               GradientBuffers& gradients,
                               RealBuffer& param_grads) {
  if (actors_) gradients.pose_grads.reserve(std::size_t{SIM_POSE_GRAD} * frame.stride);
  const std::size_t items =
      round_up(frame.particles, static_cast<std::size_t>(lanes_)) / static_cast<std::size_t>(lanes_);
  project_bwd_.run_over(
      items,
      {{"frame", frame}, particles, made.constants, made.projected, gradients, {"param_grads", param_grads}});
}

}  // namespace simuli

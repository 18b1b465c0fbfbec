// Launcher of "kernels/project_bwd.cl".
#include "host/render/backward/backward_stages.hpp"

namespace simuli {
namespace {

constexpr std::size_t kLocalSize = 32;

BuildOptions backward_options(const Variant& variant) {
  BuildOptions options = variant.options();
  // Colour is clamped at 0 in all three channels, of a LiDAR's features the intensity alone.
  return options.define("CLAMPED_CHANNELS", variant.sensor == SensorType::kCamera ? 3 : 1)
      .define("COMPENSATION", variant.compensation);
}

}  // namespace

ProjectBackwardStage::ProjectBackwardStage(const Device& device, const Variant& variant)
    : lanes_(variant.shape.lanes),
      actors_(variant.actors),
      project_bwd_(Program(device, "kernels/project_bwd.cl", backward_options(variant)), "project_bwd") {}

void ProjectBackwardStage::run(const shared::FrameParams& frame,
                               const ParticleBuffers& particles,
                               const FrameBuffers& made,
                               GradientBuffers& gradients,
                               RealBuffer& param_grads) {
  if (actors_) gradients.pose_grads.reserve(std::size_t{SIM_POSE_GRAD} * frame.stride);
  const std::size_t items =
      round_up(frame.particles, static_cast<std::size_t>(lanes_)) / static_cast<std::size_t>(lanes_);
  project_bwd_.run(round_up(items, kLocalSize),
                   kLocalSize,
                   {{"frame", frame},
                    particles,
                    made.constants,
                    made.projected,
                    {"emission", made.binned.emission},
                    gradients,
                    {"param_grads", param_grads}});
}

}  // namespace simuli

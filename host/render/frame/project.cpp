// Launcher of "kernels/project.cl".
#include "host/render/frame/stages.hpp"

namespace simuli {
namespace {

constexpr std::size_t kLocalSize = 32;

/// Only the forward projection asks for these: other kernels are one program for all.
BuildOptions forward_options(const Variant& variant) {
  BuildOptions options = variant.options();
  if (variant.order == Order::kPerRay) options.define("PER_RAY", true);
  return options.define("EXTENT", variant.extent)
      .define("SHUTTER_ITERATIONS", variant.shutter_iterations)
      .define("COMPENSATION", variant.compensation)
      .define("CULLING", variant.culling);
}

}  // namespace

ProjectStage::ProjectStage(const Device& device, const Variant& variant)
    : lanes_(variant.shape.lanes),
      actor_motion_(variant.actor_motion),
      project_(Program(device, "kernels/project.cl", forward_options(variant)), "project") {}

void ProjectStage::run(const shared::FrameParams& frame,
                       const ParticleBuffers& particles,
                       const RayBuffers& rays,
                       const FrameConstants& constants,
                       Projected& out) {
  out.reserve({.particles = frame.particles, .moving_particles = actor_motion_ ? frame.particles : 0});
  const std::size_t items =
      round_up(frame.particles, static_cast<std::size_t>(lanes_)) / static_cast<std::size_t>(lanes_);
  project_.run(round_up(items, kLocalSize), kLocalSize, {{"frame", frame}, particles, constants, rays, out});
}

}  // namespace simuli

// Launcher of "kernels/project.cl".
#include "host/render/frame/stages.hpp"
#include "host/render/rays/sensor_in_frame.hpp"

namespace simuli {
ProjectStage::ProjectStage(const Device& device, const Variant& variant)
    : lanes_(variant.frame.shape.lanes),
      actor_motion_(variant.frame.actor_motion),
      samples_(device, variant.options.precision),
      project_(Program(device, "kernels/project.cl", variant.build_options()), "project") {
  if (variant.options.projection == Projection::kMonteCarlo) samples_.normal_samples.assign(normal_samples());
}

void ProjectStage::run(const shared::FrameParams& frame,
                       const ParticleBuffers& particles,
                       const RayBuffers& rays,
                       const FrameConstants& constants,
                       Projected& out) {
  out.reserve({.particles = frame.particles, .moving_particles = actor_motion_ ? frame.particles : 0});
  const std::size_t items =
      round_up(frame.particles, static_cast<std::size_t>(lanes_)) / static_cast<std::size_t>(lanes_);
  project_.run_over(items, {{"frame", frame}, particles, constants, rays, samples_, out});
}

}  // namespace simuli

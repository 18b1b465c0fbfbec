// Launcher of "kernels/project.cl".
#include <cstdint>

#include "host/device/render/frame/paper/normal_samples.hpp"
#include "host/device/render/frame/stages.hpp"

namespace simuli {
const char* ProjectStage::file(Extent extent) {
  return extent == Extent::kExact ? "kernels/project.cl" : "paper/project.cl";
}

ProjectStage::ProjectStage(const Device& device, const Variant& variant)
    : lanes_(variant.options.shape.lanes),
      actor_motion_(variant.frame.actor_motion),
      samples_(device, variant.options.precision),
      cull_clusters_(Program(device, file(variant.options.extent), variant.build_options()), "cull_clusters"),
      project_(Program(device, file(variant.options.extent), variant.build_options()), "project") {
#if SIMULI_PAPER
  if (variant.options.projection == Projection::kMonteCarlo) samples_.normal_samples.assign(normal_samples());
#endif
}

void ProjectStage::run(const shared::FrameParams& frame,
                       const ParticleBuffers& particles,
                       const RayBuffers& rays,
                       const FrameConstants& constants,
                       Projected& out) {
  const std::uint32_t here = particles.count, paged = particles.paged ? 1 : 0;
  out.reserve({.particles = here, .moving_particles = actor_motion_ ? here : 0});
  const auto items = [this](std::size_t count) {
    const auto lanes = static_cast<std::size_t>(lanes_);
    return round_up(count, lanes) / lanes;
  };
  cull_clusters_.run_over(
      items((frame.particles + SIM_CLUSTER - 1) / SIM_CLUSTER),
      {{"frame", frame}, particles, {"cluster_stride", particles.cluster_stride}, constants, out});
  project_.run_over(items(frame.particles),
                    {{"frame", frame}, {"paged", paged}, particles, constants, rays, samples_, out});
}

}  // namespace simuli

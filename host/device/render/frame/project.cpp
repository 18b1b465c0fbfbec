// Launcher of "kernels/project.cl".
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "host/core/base/splitmix.hpp"
#include "host/device/render/frame/stages.hpp"

namespace simuli {
namespace {

/// SIM_MONTE_CARLO standard normal triples, the same always, in pairs of opposite sign so that their mean is
/// exactly 0; by splitmix64 and Box-Muller.
std::vector<double> normal_samples() {
  std::vector<double> values;
  std::uint64_t state = 0;
  const auto uniform = [&state] {
    const std::uint64_t z = splitmix(state);
    state += kSplitmixStep;
    return (static_cast<double>(z >> 11U) + 0.5) * 0x1p-53;
  };
  for (int pair = 0; pair < SIM_MONTE_CARLO / 2; ++pair) {
    double sample[3];
    for (double& value : sample) {
      const double radius = std::sqrt(-2.0 * std::log(uniform()));
      value = radius * std::cos(2.0 * std::numbers::pi * uniform());
    }
    for (const double sign : {1.0, -1.0}) {
      for (const double value : sample) values.push_back(sign * value);
    }
  }
  return values;
}

}  // namespace

ProjectStage::ProjectStage(const Device& device, const Variant& variant)
    : lanes_(variant.options.shape.lanes),
      actor_motion_(variant.frame.actor_motion),
      samples_(device, variant.options.precision),
      cull_clusters_(Program(device, "kernels/project.cl", variant.build_options()), "cull_clusters"),
      project_(Program(device, "kernels/project.cl", variant.build_options()), "project") {
  if (variant.options.projection == Projection::kMonteCarlo) samples_.normal_samples.assign(normal_samples());
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

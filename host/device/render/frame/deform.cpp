// Launcher of "kernels/deform.cl".
#include "host/device/render/frame/stages.hpp"

namespace simuli {
namespace {

BuildOptions deform_options(Precision precision) {
  BuildOptions options;
  return options.real(precision);
}

}  // namespace

DeformStage::DeformStage(const Device& device, Precision precision)
    : deform_(Program(device, "kernels/deform.cl", deform_options(precision)), "deform") {}

void DeformStage::run(const ParticleBuffers& particles, FrameConstants& constants) {
  constants.deform_offset.reserve(std::size_t{3} * particles.stride);
  const auto count = static_cast<std::uint32_t>(particles.actor_list.count());
  const FrameConstants& read = constants;
  deform_.run_over(count,
                   {{"count", count},
                    {"stride", particles.stride},
                    particles,
                    {"deform_at", read.deform_at},
                    {"deform_shapes", read.deform_shapes},
                    {"deform_offset", constants.deform_offset}});
}

}  // namespace simuli

// Launcher of "kernels/regularize.cl".
#include "host/render/train/regularize.hpp"

#include "host/render/options/lane_shape.hpp"

namespace simuli {
RegularizeStage::RegularizeStage(const Device& device, Precision precision)
    : lanes_(lane_shape_of(device, precision).lanes),
      regularize_(Program(device, "kernels/regularize.cl", lane_options(device, precision, lanes_)),
                  "regularize") {}

void RegularizeStage::run(const ParticleBuffers& particles,
                          const RegularizeScale& scale,
                          RealBuffer& param_grads) {
  regularize_.run_over(particles.stride / static_cast<std::size_t>(lanes_),
                       {{"particles", particles.count},
                        {"stride", particles.stride},
                        {"by_scale", scale.scale},
                        {"by_opacity", scale.opacity},
                        {"by_entropy", scale.entropy},
                        particles,
                        {"param_grads", param_grads}});
}

}  // namespace simuli

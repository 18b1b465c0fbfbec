// Launcher of "kernels/environment.cl".
#include "host/device/render/frame/stages.hpp"
#include "host/device/render/options/lane_shape.hpp"

namespace simuli {
EnvironmentStage::EnvironmentStage(const Device& device, Precision precision, int lanes)
    : lanes_(lanes == 0 ? lane_shape_of(device, precision).lanes : lanes),
      environment_(Program(device, "kernels/environment.cl", lane_options(device, precision, lanes_)),
                   "environment") {}

void EnvironmentStage::run(const shared::FrameParams& frame,
                           const EnvironmentBuffers& environment,
                           const FrameConstants& constants,
                           const WorldRays& world_rays,
                           Blended& out) {
  environment_.run_over(frame.slots / static_cast<std::size_t>(lanes_),
                        {{"frame", frame},
                         {"width", environment.width},
                         {"height", environment.height},
                         constants,
                         world_rays,
                         environment,
                         out});
}

}  // namespace simuli

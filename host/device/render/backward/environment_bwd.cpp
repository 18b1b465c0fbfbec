// Launcher of "kernels/environment_bwd.cl".
#include <bit>

#include "host/device/render/backward/backward_stages.hpp"
#include "host/device/render/options/lane_shape.hpp"

namespace simuli {
namespace {

Program program(const Device& device, Precision precision, int lanes) {
  return {device, "kernels/environment_bwd.cl", lane_options(device, precision, lanes)};
}

}  // namespace

EnvironmentBackwardStage::EnvironmentBackwardStage(const Device& device, Precision precision, int lanes)
    : device_(device),
      lanes_(lanes == 0 ? lane_shape_of(device, precision).lanes : lanes),
      sort_(device),
      scratch_(device, precision),
      cells_(program(device, precision, lanes_), "environment_cells"),
      ranges_(Program(device, "kernels/bin.cl", BuildOptions().define("LS", chunks_of(device, 0).group)),
              "tile_ranges"),
      gather_(program(device, precision, lanes_), "environment_gather") {}

void EnvironmentBackwardStage::run(const shared::FrameParams& frame,
                                   const EnvironmentBuffers& environment,
                                   double tv_scale,
                                   const FrameConstants& constants,
                                   const WorldRays& world_rays,
                                   const Blended& blended,
                                   const GradientBuffers& gradients,
                                   RealBuffer& grads) {
  const std::uint32_t cells = environment.width * environment.height + 1;  // the last cell: rays that see no texel
  scratch_.reserve({frame.slots, cells});
  grads.reserve(environment.texture.count());
  cells_.run_over(frame.slots / static_cast<std::size_t>(lanes_),
                  {{"frame", frame},
                   {"width", environment.width},
                   {"height", environment.height},
                   constants,
                   world_rays,
                   blended,
                   scratch_});
  sort_.run(scratch_.cell, scratch_.slot, frame.slots, std::bit_width(cells - 1));
  const Chunks chunks = chunks_of(device_, frame.slots);
  ranges_.run(chunks.work_items,
              chunks.group,
              {{"tile", scratch_.cell},
               {"k", frame.slots},
               {"chunk", chunks.chunk},
               {"tiles", cells},
               {"first", scratch_.first}});
  gather_.run_over(std::size_t{cells} - 1,
                   {{"frame", frame},
                    {"width", environment.width},
                    {"height", environment.height},
                    {"tv_scale", tv_scale},
                    {"first", scratch_.first},
                    {"slot", scratch_.slot},
                    {"fraction", scratch_.fraction},
                    blended,
                    {"grad_out", gradients.grad_out},
                    environment,
                    {"grads", grads}});
}

}  // namespace simuli

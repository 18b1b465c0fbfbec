// Launcher of "kernels/rays.cl".
#include "host/device/render/frame/stages.hpp"

namespace simuli {

RaysStage::RaysStage(const Device& device, const Variant& variant)
    : lanes_(variant.options.shape.lanes),
      rows_(variant.frame.actor_motion ? 7
            : variant.frame.origins    ? 6
                                       : 3),
      rays_(Program(device, "kernels/rays.cl", variant.build_options()), "rays") {}

void RaysStage::run(const shared::FrameParams& frame,
                    const RayBuffers& rays,
                    const FrameConstants& constants,
                    WorldRays& out) {
  out.reserve({.slots = frame.slots, .ray_rows = rows_});
  const std::size_t items = frame.slots / static_cast<std::size_t>(lanes_);
  rays_.run(
      items, frame.tile_rays / static_cast<std::size_t>(lanes_), {{"frame", frame}, constants, rays, out});
}

}  // namespace simuli

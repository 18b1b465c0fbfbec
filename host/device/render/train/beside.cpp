// Launcher of "kernels/beside.cl".
#include "host/device/render/train/beside.hpp"

namespace simuli {

BesideStage::BesideStage(const Device& device, const Variant& variant)
    : lanes_(static_cast<std::size_t>(variant.options.shape.lanes)),
      beside_(Program(device, "kernels/beside.cl", variant.build_options()), "beside") {}

void BesideStage::run(const shared::FrameParams& frame,
                      const RayGrid& grid,
                      const Buffer<std::int32_t>& slot_of_ray,
                      const FrameBuffers& made,
                      const SeenSurfaces& recorded,
                      const RealBuffer& picture,
                      RealBuffer& shown) {
  beside_.run(frame.slots / lanes_,
              frame.tile_rays / lanes_,
              {{"frame", frame},
               {"width", static_cast<std::uint32_t>(grid.width)},
               {"height", static_cast<std::uint32_t>(grid.height)},
               {"now", made.constants.sensor},
               {"world_ray", made.rays.world_ray},
               {"met", made.blended.out},
               {"recorded", recorded.sensor},
               {"seen", recorded.out},
               {"slot_of_ray", slot_of_ray},
               {"picture", picture},
               {"shown", shown}});
}

}  // namespace simuli

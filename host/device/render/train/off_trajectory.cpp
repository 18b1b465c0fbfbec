// Launcher of "kernels/off_trajectory.cl".
#include "host/device/render/train/off_trajectory.hpp"

namespace simuli {

OffTrajectoryStage::OffTrajectoryStage(const Device& device, const Variant& variant)
    : lanes_(static_cast<std::size_t>(variant.options.shape.lanes)),
      off_trajectory_(Program(device, "kernels/off_trajectory.cl", variant.build_options()), "off_trajectory") {}

void OffTrajectoryStage::run(const shared::FrameParams& frame,
                      const RayGrid& grid,
                      const Buffer<std::int32_t>& slot_of_ray,
                      const FrameBuffers& made,
                      const SeenSurfaces& recorded,
                      const RealBuffer& picture,
                      RealBuffer& shown) {
  off_trajectory_.run(frame.slots / lanes_,
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

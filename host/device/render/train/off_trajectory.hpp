#pragma once
#include "host/device/render/frame/stages.hpp"
#include "host/device/render/rays/ray_grid.hpp"
#include "host/device/render/train/seen_surfaces.hpp"

namespace simuli {

/// What a recorded picture shows of the surfaces of a view beside it.
class OffTrajectoryStage {
 public:
  OffTrajectoryStage(const Device& device, const Variant& variant);
  /// `made`: the view beside, rendered of the same surfaces by the same rays as `recorded`, whose picture is
  /// picture[3][slots], negative: not known. shown[3][slots]: the colour of what each ray meets, or of all
  /// that it could meet, -1 where the picture does not tell.
  void run(const shared::FrameParams& frame,
           const RayGrid& grid,
           const Buffer<std::int32_t>& slot_of_ray,
           const FrameBuffers& made,
           const SeenSurfaces& recorded,
           const RealBuffer& picture,
           RealBuffer& shown);

 private:
  std::size_t lanes_;
  Kernel off_trajectory_;
};

}  // namespace simuli

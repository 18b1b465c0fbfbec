#pragma once
#include "host/device/render/frame/stages.hpp"
#include "host/device/render/rays/ray_grid.hpp"
#include "host/device/render/train/seen_surfaces.hpp"

namespace simuli {

/// Colours an off-trajectory view of surfaces from a recorded picture.
class OffTrajectoryStage {
 public:
  OffTrajectoryStage(const Device& device, const Variant& variant);
  /// `made`: the off-trajectory rendering of the same surfaces with the same rays as `recorded`, whose picture
  /// is picture[3][slots] (negative: unknown). shown[3][slots]: the colour of each ray's surface, or of all its
  /// possible surfaces; -1 where unknown.
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

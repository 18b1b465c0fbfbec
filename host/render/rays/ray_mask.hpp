#pragma once
// Ray-based culling (docs/METHOD.md section 6): where a LiDAR's requested rays are, as a summed-area table.
#include "host/render/frame/stages.hpp"

namespace simuli {

class RayMaskStage {
 public:
  RayMaskStage(const Device& device, Precision precision);
  /// The rays that `rays` holds a direction of -> its mask_row_of_row and areas, and the grid's constants of
  /// them. Whether some cell holds no ray: only then can the table cull anything. Waits.
  bool run(RayGrid& grid, const RayMaskSize& size, RayBuffers& rays);

 private:
  Device device_;
  Kernel<shared::FrameParams,
         BufRealConst,
         BufRealConst,
         Buf<const std::uint32_t>,
         Buf<const std::uint32_t>,
         RealScalar,
         RealScalar,
         std::uint32_t,
         Buf<std::uint32_t>>
      cells_;
  Kernel<Buf<const std::uint32_t>, std::uint32_t, std::uint32_t, Buf<std::uint32_t>> row_sums_;
  Kernel<std::uint32_t, std::uint32_t, Buf<std::uint32_t>> column_sums_;
};

}  // namespace simuli

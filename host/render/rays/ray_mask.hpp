#pragma once
// Ray-based culling (docs/METHOD.md section 6): where a LiDAR's requested rays are, as a summed-area table.
#include "host/render/rays/ray_buffers.hpp"
#include "host/runtime/kernel.hpp"

namespace simuli {

struct RayMaskScratch : BufferTable<RayMaskSize> {
  using BufferTable::BufferTable;
  Words cells{*this, "cells", [](const RayMaskSize& s) {
                return static_cast<std::uint64_t>(s.rows) * static_cast<std::uint64_t>(s.columns);
              }};
};

class RayMaskStage {
 public:
  RayMaskStage(const Device& device, Precision precision);
  /// The rays that `rays` holds a direction of -> its mask_row_of_row and areas, and the grid's constants of
  /// them. Whether some cell holds no ray: only then can the table cull anything. Waits.
  bool run(RayGrid& grid, const RayMaskSize& size, RayBuffers& rays);

 private:
  RayMaskScratch scratch_;
  Kernel cells_, row_sums_, column_sums_;
};

}  // namespace simuli

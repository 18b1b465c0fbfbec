#pragma once
// Ray-based culling (docs/METHOD.md section 6): where a LiDAR's requested rays are, as a summed-area table.
#include "cl/shared/sensor_constants.h"
#include "host/device/render/rays/ray_buffers.hpp"
#include "host/device/runtime/kernel.hpp"

namespace simuli {

/// Cells over a LiDAR's sweep, and over its beams: each row has equally many.
struct RayMaskSize {
  int columns = 1600;
  int rows = 8;
};

struct RayMaskScratch : BufferTable<RayMaskSize> {
  using BufferTable::BufferTable;
  Words cells{*this, "cells", [](const RayMaskSize& s) {
                return static_cast<std::uint64_t>(s.rows) * static_cast<std::uint64_t>(s.columns);
              }};
};

class RayMaskStage {
 public:
  RayMaskStage(const Device& device, Precision precision);
  /// The rays that `requested` holds a direction of, `all` of them or some -> its mask_row_of_row and areas,
  /// and the model's mask_scale and mask_columns. Whether some cell holds no ray: only then can the table cull
  /// anything. Waits.
  bool run(const RayGrid& grid,
           bool all,
           const RayLayout& layout,
           RequestedRays& requested,
           shared::ModelConstants<double>& model);

 private:
  RayMaskScratch scratch_;
  Kernel cells_, row_sums_, column_sums_;
};

}  // namespace simuli

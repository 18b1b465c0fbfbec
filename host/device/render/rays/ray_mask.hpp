#pragma once
// Ray-based culling (docs/METHOD.md section 6): the requested rays of a LiDAR as a summed-area table.
#include "cl/shared/sensor_constants.h"
#include "host/device/render/rays/ray_buffers.hpp"
#include "host/device/runtime/kernel.hpp"

namespace simuli {

/// Cells along a LiDAR's sweep and beams; each row has the same number.
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
  /// Computes mask_row_of_row and areas of `requested`, and the model's mask_scale and mask_columns, for all
  /// rays or some. Returns whether a cell is empty, which culling requires. Waits.
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

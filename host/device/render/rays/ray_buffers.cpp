#include "host/device/render/rays/ray_buffers.hpp"

namespace simuli {

RayLayout::RayLayout(const Device& device, const RayGrid& grid, Precision precision)
    : RayLayout(device, precision) {
  u.assign(grid.u);
  row_lut.assign(grid.row_lut);
  row_elevation.assign(grid.row_elevation);
  tile_rows.assign(grid.tile_rows);
  tile_row_of_row.assign(grid.tile_row_of_row);
  column_of_bin.assign(grid.column_of_bin);
}

}  // namespace simuli

// ray_mask.cl - cells with requested LiDAR rays as a summed-area table (procedure 2). Launcher: host/device/render/rays/ray_mask.cpp
// Rebuilt when the requested rays change. Rays and particles find their cells by the same functions.
#include "math/sensor.h"

/// Marks cells. One work-item per slot.
/// in  sensor_ray[7][slots], ray_u[slots]; tile_rows[tiles_y + 1]; mask_row_of_row[rows]
/// out cells[mask rows][columns]: 1 where the cell contains a ray, else unchanged
__kernel void ray_mask_cells(const FrameParams frame,
                             __global const real* sensor_ray,
                             __global const real* ray_u,
                             __global const uint* tile_rows,
                             __global const uint* mask_row_of_row,
                             const real first,
                             const real scale,
                             const uint columns,
                             __global uint* cells) {
  const uint slot = get_global_id(0);
  const uint s = frame.slots;
  if (slot >= s) return;
  if (sensor_ray[slot] == R(0.0) && sensor_ray[s + slot] == R(0.0) && sensor_ray[2 * s + slot] == R(0.0))
    return;
  const uint tile = slot / frame.tile_rays;
  const uint row = tile_rows[tile / frame.tiles_x] + slot % frame.tile_rays / SIM_RAY_BLOCK / frame.row_slots;
  const uint column = cell_of(ray_u[slot], first, scale, (real)columns);
  atomic_or(cells + mask_row_of_row[row] * columns + column, 1u);
}

/// Sums along rows. One work-item per row of areas.
/// out areas[rows + 1][columns + 1]: first row and column 0
__kernel void ray_mask_row_sums(__global const uint* cells,
                                const uint rows,
                                const uint columns,
                                __global uint* areas) {
  const uint y = get_global_id(0);
  if (y > rows) return;
  __global uint* row = areas + (ulong)y * (columns + 1);
  uint sum = 0;
  row[0] = 0;
  for (uint x = 0; x < columns; ++x) {
    sum += y == 0 ? 0 : cells[(ulong)(y - 1) * columns + x];
    row[x + 1] = sum;
  }
}

/// Sums along columns, one work-item each: areas[y][x] then counts the occupied cells of all rows < y and
/// columns < x.
__kernel void ray_mask_column_sums(const uint rows, const uint columns, __global uint* areas) {
  const uint x = get_global_id(0);
  if (x > columns) return;
  for (uint y = 1; y <= rows; ++y) {
    areas[(ulong)y * (columns + 1) + x] += areas[(ulong)(y - 1) * (columns + 1) + x];
  }
}

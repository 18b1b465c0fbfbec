// color_grid.cl - applies a bilateral grid to a picture. Launcher: host/device/render/frame/color_grid.cpp
#include "math/color_grid.h"
#include "shared/layout.h"

/// Applies the affine transform for a pixel's position and luminance (METHOD section 9). One pixel per
/// work-item.
/// in  grid[GRID_Y][GRID_X][GRID_Z][16], from `first` on; out[6][slots]
/// out picture[3][slots]
__kernel void color_grid(const FrameParams frame,
                         const uint width,
                         const uint height,
                         const uint first,
                         __global const real* grid,
                         __global const real* out,
                         __global real* picture) {
  const uint i = get_global_id(0);
  const uint s = frame.slots;
  if (i >= s) return;
  const uint tile = i / SIM_TILE_RAYS, inside = i % SIM_TILE_RAYS;
  // Slots outside the picture have no pixel; applying the nearest pixel's transform to them is harmless.
  const uint block = inside / SIM_RAY_BLOCK, place = inside % SIM_RAY_BLOCK;
  const uint column = block % SIM_TILE_BLOCKS * SIM_BLOCK_SIDE + place % SIM_BLOCK_SIDE;
  const uint row = block / SIM_TILE_BLOCKS * SIM_BLOCK_SIDE + place / SIM_BLOCK_SIDE;
  const uint x = min(tile % frame.tiles_x * SIM_TILE_SIDE + column, width - 1);
  const uint y = min(tile / frame.tiles_x * SIM_TILE_SIDE + row, height - 1);
  const real rgb[3] = {out[i], out[s + i], out[2 * s + i]};
  real fx, fy;
  const uint cx = grid_cell(x, width, GRID_X, &fx);
  const uint cy = grid_cell(y, height, GRID_Y, &fy);
  GridSlice slice;
  grid_slice(grid + first, cx, cy, fx, fy, rgb, &slice);
  real graded[3];
  grid_apply(slice.transform, rgb, graded);
  SIM_EACH(c, 3) picture[c * s + i] = graded[c];
}

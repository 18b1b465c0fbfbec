// color_grid_bwd.cl - gradients of a bilateral grid and of its picture. Launcher: host/render/backward/color_grid_bwd.cpp
#include "math/color_grid.h"
#include "shared/layout.h"

/// A work-item takes the pixels of one row y in one column cx of cells, and sums what its two columns of
/// vertices get, x weights applied, y weights not yet.
/// in  as color_grid; grad_out[3][slots]: dL/d(picture)
/// out grad_out[3][slots]: dL/d(colours before the grid), in place
///     partial[height][GRID_X - 1][2][GRID_Z][16]
__kernel void color_grid_rows(const FrameParams frame,
                              const uint width,
                              const uint height,
                              const uint first,
                              __global const real* grid,
                              __global const real* out,
                              __global real* grad_out,
                              __global real* partial) {
  const uint cx = get_global_id(0), y = get_global_id(1);
  const uint s = frame.slots;
  Vertex sum[2 * GRID_Z];
  for (int k = 0; k < 2 * GRID_Z; ++k) sum[k] = (Vertex)(R(0.0));
  real fx, fy;
  const uint cy = grid_cell(y, height, GRID_Y, &fy);
  const uint row = y / SIM_SLOT_ROWS * frame.tiles_x * SIM_TILE_RAYS + y % SIM_SLOT_ROWS * SIM_SLOT_ROW;
  const uint end = grid_cell_begin(cx + 1, width, GRID_X);
  for (uint x = grid_cell_begin(cx, width, GRID_X); x < end; ++x) {
    const uint i = row + x / SIM_SLOT_ROW * SIM_TILE_RAYS + x % SIM_SLOT_ROW;
    const real rgb[3] = {out[i], out[s + i], out[2 * s + i]};
    const real g[3] = {grad_out[i], grad_out[s + i], grad_out[2 * s + i]};
    (void)grid_cell(x, width, GRID_X, &fx);
    GridSlice slice;
    grid_slice(grid + first, cx, cy, fx, fy, rgb, &slice);
    const Vertex m = slice.transform;
    real slope[3];
    grid_apply(slice.along_z, rgb, slope);
    const real by_luminance = slice.z_slope * (g[0] * slope[0] + g[1] * slope[1] + g[2] * slope[2]);
    grad_out[i] = m.s0 * g[0] + m.s4 * g[1] + m.s8 * g[2] + LUMINANCE_R * by_luminance;
    grad_out[s + i] = m.s1 * g[0] + m.s5 * g[1] + m.s9 * g[2] + LUMINANCE_G * by_luminance;
    grad_out[2 * s + i] = m.s2 * g[0] + m.s6 * g[1] + m.sa * g[2] + LUMINANCE_B * by_luminance;
    const REAL_VECTOR(4) colour = (REAL_VECTOR(4))(rgb[0], rgb[1], rgb[2], R(1.0));
    const Vertex outer = (Vertex)(g[0] * colour, g[1] * colour, g[2] * colour, (REAL_VECTOR(4))(R(0.0)));
    const Vertex low = outer * (R(1.0) - slice.fz), high = outer * slice.fz;
    sum[slice.z] += (R(1.0) - fx) * low;
    sum[slice.z + 1] += (R(1.0) - fx) * high;
    sum[GRID_Z + slice.z] += fx * low;
    sum[GRID_Z + slice.z + 1] += fx * high;
  }
  __global real* target = partial + (ulong)(y * (GRID_X - 1) + cx) * (2 * GRID_Z * GRID_VERTEX);
  for (int k = 0; k < 2 * GRID_Z; ++k) vstore16(sum[k], k, target);
}

/// One vertex per work-item: sums its rows, then adds the gradients of tv_scale x the squared differences of
/// neighbours and of drift_scale x the squared difference to the identity.
/// out grads[GRID_Y][GRID_X][GRID_Z][16]
__kernel void color_grid_gather(const uint height,
                                const uint first,
                                const real tv_scale,
                                const real drift_scale,
                                __global const real* all_grids,
                                __global const real* partial,
                                __global real* grads) {
  const uint vertex = get_global_id(0);
  if (vertex >= GRID_X * GRID_Y * GRID_Z) return;
  const uint z = vertex % GRID_Z, x = vertex / GRID_Z % GRID_X, y = vertex / (GRID_Z * GRID_X);
  Vertex sum = (Vertex)(R(0.0));
  const uint begin = y == 0 ? 0 : grid_cell_begin(y - 1, height, GRID_Y);
  const uint end = grid_cell_begin(y + 1, height, GRID_Y);
  for (uint row = begin; row < end; ++row) {
    real fy;
    const uint cy = grid_cell(row, height, GRID_Y, &fy);
    const real weight = cy == y ? R(1.0) - fy : fy;
    const __global real* cells = partial + (ulong)(row * (GRID_X - 1)) * (2 * GRID_Z * GRID_VERTEX);
    Vertex here = (Vertex)(R(0.0));
    if (x > 0) here += vload16((x - 1) * 2 * GRID_Z + GRID_Z + z, cells);
    if (x + 1 < GRID_X) here += vload16(x * 2 * GRID_Z + z, cells);
    sum += weight * here;
  }
  const __global real* grid = all_grids + first;
  const Vertex here = vload16(vertex, grid);
  Vertex tv = (Vertex)(R(0.0));
  if (z > 0) tv += here - vload16(vertex - 1, grid);
  if (z + 1 < GRID_Z) tv += here - vload16(vertex + 1, grid);
  if (x > 0) tv += here - vload16(vertex - GRID_Z, grid);
  if (x + 1 < GRID_X) tv += here - vload16(vertex + GRID_Z, grid);
  if (y > 0) tv += here - vload16(vertex - GRID_Z * GRID_X, grid);
  if (y + 1 < GRID_Y) tv += here - vload16(vertex + GRID_Z * GRID_X, grid);
  const real o = R(0.0), l = R(1.0);
  const Vertex identity = (Vertex)(l, o, o, o, o, l, o, o, o, o, l, o, o, o, o, o);
  vstore16(sum + R(2.0) * (tv_scale * tv + drift_scale * (here - identity)), vertex, grads);
}

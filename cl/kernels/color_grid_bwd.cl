// color_grid_bwd.cl - gradients of a bilateral grid and of its input picture. Launcher: host/device/render/backward/color_grid_bwd.cpp
#include "math/color_grid.h"
#include "shared/layout.h"

/// Returns the gradient of a pixel for the vertices around it, without interpolation weights.
FN Vertex pixel_vertex(const real* rgb, const real* g) {
  const REAL_VECTOR(4) colour = (REAL_VECTOR(4))(rgb[0], rgb[1], rgb[2], R(1.0));
  return (Vertex)(g[0] * colour, g[1] * colour, g[2] * colour, (REAL_VECTOR(4))(R(0.0)));
}

// Levels summed by a work-item of color_grid_rows(): 1, or GRID_Z. All levels at once exceed a GPU's registers;
// one by one a CPU reads each pixel GRID_Z times.
#ifndef GRID_LEVELS
#define GRID_LEVELS 1
#endif

/// Sums gradients over the pixels of one picture row y in one column cx of grid cells, for the two vertices of
/// each level; x weights are applied, y weights are not. One (y, cx) per work-item, GRID_LEVELS levels.
/// in  out[6][slots]; grad_out[3][slots]: dL/d(picture)
/// out partial[height][GRID_X - 1][2][GRID_Z][16]
__kernel void color_grid_rows(const FrameParams frame,
                              const uint width,
                              const uint height,
                              __global const real* out,
                              __global const real* grad_out,
                              __global real* partial) {
  const uint items = GRID_Z / GRID_LEVELS;
  const uint z = get_global_id(0) % items * GRID_LEVELS, column = get_global_id(0) / items;
  const uint cx = column % (GRID_X - 1), y = column / (GRID_X - 1);
  const uint s = frame.slots;
  if (y >= height) return;
  Vertex left[GRID_LEVELS], right[GRID_LEVELS];
  SIM_EACH(k, GRID_LEVELS) left[k] = right[k] = (Vertex)(R(0.0));
  const uint row = SIM_SLOT_OF_ROW(y, frame.tiles_x), end = grid_cell_begin(cx + 1, width, GRID_X);
  for (uint x = grid_cell_begin(cx, width, GRID_X); x < end; ++x) {
    const uint i = row + SIM_SLOT_OF_COLUMN(x);
    const real rgb[3] = {out[i], out[s + i], out[2 * s + i]};
    real fz, z_slope;
    const uint low = grid_level(rgb, &fz, &z_slope);
    if (low + 1 < z || low >= z + GRID_LEVELS) continue;
    real fx;
    (void)grid_cell(x, width, GRID_X, &fx);
    const real g[3] = {grad_out[i], grad_out[s + i], grad_out[2 * s + i]};
    const Vertex vertex = pixel_vertex(rgb, g);
    SIM_EACH(k, 2) {
      const uint level = low + k - z;  // below z: out of range
      if (level >= GRID_LEVELS) continue;
      const Vertex part = vertex * (k == 0 ? R(1.0) - fz : fz);
      left[level] += (R(1.0) - fx) * part;
      right[level] += fx * part;
    }
  }
  __global real* target = partial + (ulong)column * (2 * GRID_Z * GRID_VERTEX);
  SIM_EACH(k, GRID_LEVELS) {
    vstore16(left[k], z + k, target);
    vstore16(right[k], GRID_Z + z + k, target);
  }
}

/// Backpropagates to the input picture, after color_grid_rows(). One pixel per work-item.
/// in  as color_grid
/// out grad_out[3][slots]: dL/d(colours before the grid), in place
__kernel void color_grid_pixels(const FrameParams frame,
                                const uint width,
                                const uint height,
                                const uint first,
                                __global const real* grid,
                                __global const real* out,
                                __global real* grad_out) {
  const uint x = get_global_id(0) % width, y = get_global_id(0) / width;
  const uint s = frame.slots;
  if (y >= height) return;
  const uint i = SIM_SLOT_OF_ROW(y, frame.tiles_x) + SIM_SLOT_OF_COLUMN(x);
  const real rgb[3] = {out[i], out[s + i], out[2 * s + i]};
  const real g[3] = {grad_out[i], grad_out[s + i], grad_out[2 * s + i]};
  real fx, fy;
  const uint cx = grid_cell(x, width, GRID_X, &fx), cy = grid_cell(y, height, GRID_Y, &fy);
  GridSlice slice;
  grid_slice(grid + first, cx, cy, fx, fy, rgb, &slice);
  const Vertex m = slice.transform;
  real slope[3];
  grid_apply(slice.along_z, rgb, slope);
  const real by_luminance = slice.z_slope * (g[0] * slope[0] + g[1] * slope[1] + g[2] * slope[2]);
  const REAL_VECTOR(4) luminance = (REAL_VECTOR(4))(LUMINANCE_R, LUMINANCE_G, LUMINANCE_B, R(0.0));
  const REAL_VECTOR(4) before = m.s0123 * g[0] + m.s4567 * g[1] + m.s89ab * g[2] + luminance * by_luminance;
  grad_out[i] = before.s0;
  grad_out[s + i] = before.s1;
  grad_out[2 * s + i] = before.s2;
}

/// Sums the rows of a vertex, then adds the gradients of tv_scale times the squared differences to neighbours
/// and drift_scale times the squared difference to the identity. One vertex per work-item.
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

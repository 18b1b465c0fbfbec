// color_grid.h - slices a bilateral grid of affine colour transforms, for the forward and the backward pass.
// Build: GRID_X, GRID_Y, GRID_Z >= 2 vertices. A vertex has 16 reals: 3 rows of 4, the last column is added; 4
// are unused.
#ifndef SIMULI_CL_MATH_COLOR_GRID_H
#define SIMULI_CL_MATH_COLOR_GRID_H
#include "math/lanes.h"

#define GRID_VERTEX 16
typedef REAL_VECTOR(16) Vertex;

// Vertices are stored in the order y, x, z, so that vertices of one column are consecutive.
#define GRID_AT(x, y, z) ((((y)*GRID_X + (x)) * GRID_Z) + (z))

/// Returns the cell of pixel `i` of `size` along an axis with `vertices`, and the fraction within it, computed
/// in integers so that all passes agree exactly. The first and the last vertex are on the picture's borders.
FN uint grid_cell(uint i, uint size, uint vertices, real* fraction) {
  const uint scaled = (2 * i + 1) * (vertices - 1);
  const uint cell = min(scaled / (2 * size), vertices - 2);
  *fraction = (real)(scaled - cell * 2 * size) / (real)(2 * size);
  return cell;
}

/// Returns the first pixel of a cell, which ends the previous cell; `cell` == vertices - 1 gives the size.
FN uint grid_cell_begin(uint cell, uint size, uint vertices) {
  if (cell >= vertices - 1) return size;
  const uint edge = 2 * cell * size;
  const uint step = vertices - 1;
  return edge <= step ? 0 : (edge - step + 2 * step - 1) / (2 * step);
}

/// The transform at a pixel and the inputs of its gradient.
typedef struct {
  uint corner[4];  // vertices (x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1) at the lower z
  real weight[4];
  real fz;  // weight of z + 1
  uint z;
  real z_slope;  // d(position along z)/d(luminance): 0 for luminances outside [0, 1]
  Vertex transform;
  Vertex along_z;  // derivative by the position along z
} GridSlice;

#define LUMINANCE_R R(0.299)
#define LUMINANCE_G R(0.587)
#define LUMINANCE_B R(0.114)

/// Returns the lower level of a pixel's cell; fz: weight of the next level; z_slope as in GridSlice.
FN uint grid_level(const real* rgb, real* fz, real* z_slope) {
  const real luminance = fma(LUMINANCE_R, rgb[0], fma(LUMINANCE_G, rgb[1], LUMINANCE_B * rgb[2]));
  const int inside = luminance > R(0.0) && luminance < R(1.0);
  const real place = (inside ? luminance : (luminance > R(0.5) ? R(1.0) : R(0.0))) * (real)(GRID_Z - 1);
  *z_slope = inside ? (real)(GRID_Z - 1) : R(0.0);
  const uint z = min((uint)place, (uint)(GRID_Z - 2));
  *fz = place - (real)z;
  return z;
}

FN void grid_slice(
    __global const real* grid, uint cx, uint cy, real fx, real fy, const real* rgb, GridSlice* s) {
  s->z = grid_level(rgb, &s->fz, &s->z_slope);
  s->corner[0] = GRID_AT(cx, cy, s->z);
  s->corner[1] = GRID_AT(cx + 1, cy, s->z);
  s->corner[2] = GRID_AT(cx, cy + 1, s->z);
  s->corner[3] = GRID_AT(cx + 1, cy + 1, s->z);
  s->weight[0] = (R(1.0) - fx) * (R(1.0) - fy);
  s->weight[1] = fx * (R(1.0) - fy);
  s->weight[2] = (R(1.0) - fx) * fy;
  s->weight[3] = fx * fy;
  Vertex low = (Vertex)(R(0.0)), high = (Vertex)(R(0.0));
  SIM_EACH(k, 4) {
    low += s->weight[k] * vload16(s->corner[k], grid);
    high += s->weight[k] * vload16(s->corner[k] + 1, grid);
  }
  s->along_z = high - low;
  s->transform = low + s->fz * s->along_z;
}

/// Computes m (rgb, 1) with vectors: otherwise CPU compilers extract elements of a vertex one by one.
FN void grid_apply(Vertex m, const real* rgb, real* out) {
  const REAL_VECTOR(4) product = m.s048c * rgb[0] + m.s159d * rgb[1] + m.s26ae * rgb[2] + m.s37bf;
  out[0] = product.s0;
  out[1] = product.s1;
  out[2] = product.s2;
}

#endif

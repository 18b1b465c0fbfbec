// deform.h - the deformation grid that moves points of an actor in its frame (METHOD section 2).
#ifndef SIMULI_CL_MATH_DEFORM_H
#define SIMULI_CL_MATH_DEFORM_H
#include "math/elementary.h"
#include "shared/layout.h"

/// The grid cell of a point, and the point's fractions within it.
typedef struct {
  uint node[3];    // of the cell's first corner
  uint nodes[3];   // nodes of the grid along each axis
  real within[3];  // fraction, 0 to 1
  real slope[3];   // cells per metre; 0 outside the grid, where offsets are those of its faces
} DeformCell;

/// Position of p (m) along axis k of the grid, in cells from the first face, clamped to the faces.
/// in  shape of one actor: SIM_D_HEADER reals (half sides of its box, m; nodes along them), then
///     offsets[nodes][3]
FN real deform_place(__global const real* shape, int k, real p) {
  const real half_m = shape[SIM_D_HALF + k], cells = shape[SIM_D_NODES + k] - R(1.0);
  const real at = R(0.5) * cells * (p / half_m + R(1.0));
  return at > R(0.0) ? (at < cells ? at : cells) : R(0.0);  // NaN: the first face
}

FN void deform_cell(__global const real* shape, const real* p, DeformCell* cell) {
  SIM_EACH(k, 3) {
    const real cells = shape[SIM_D_NODES + k] - R(1.0);
    const real at = deform_place(shape, k, p[k]);
    const real first = min(floor(at), cells - R(1.0));
    cell->node[k] = (uint)first;
    cell->nodes[k] = (uint)cells + 1;
    cell->within[k] = at - first;
    cell->slope[k] = at > R(0.0) && at < cells ? R(0.5) * cells / shape[SIM_D_HALF + k] : R(0.0);
  }
}

/// Index of a corner's node; corner: bit k set for the far side along axis k.
FN uint deform_node(const DeformCell* cell, uint corner) {
  const uint x = cell->node[0] + (corner & 1u), y = cell->node[1] + (corner >> 1 & 1u),
             z = cell->node[2] + (corner >> 2);
  return (z * cell->nodes[1] + y) * cell->nodes[0] + x;
}

/// Interpolation weight of the corner along axis k.
FN real deform_share(const DeformCell* cell, uint corner, int k) {
  return corner >> k & 1u ? cell->within[k] : R(1.0) - cell->within[k];
}

#endif

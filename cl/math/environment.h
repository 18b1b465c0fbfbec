// environment.h - lookup of directions in the environment map: an equirectangular picture of world directions,
// centre along +x, left half +y, top +z. Texels have 4 reals: colour and one unused.
#ifndef SIMULI_CL_MATH_ENVIRONMENT_H
#define SIMULI_CL_MATH_ENVIRONMENT_H
#include "math/elementary.h"

/// Position of a direction in texel centres: x in [0, width), periodic; y in [0, height - 1].
FN void environment_place(F dx, F dy, F dz, uint width, uint height, F* x, F* y) {
  const F azimuth = atan2_lanes(dy, dx);
  const F elevation = atan2_lanes(dz, sqrt(fma(dx, dx, dy * dy)));
  const real w = (real)width, last = (real)height - R(1.0);
  const F round_x = fma(azimuth, (F)(w * R(-0.15915494309189533577)), (F)(R(0.5) * w - R(0.5)));
  *x = SEL(round_x < R(0.0), round_x + w, round_x);
  *x = SEL(*x < w, *x, (F)R(0.0));  // values just below w may round to w
  const F up = fma(elevation, (F)((real)height * R(-0.31830988618379067154)), (F)(R(0.5) * last));
  *y = VMAX(VMIN(up, (F)last), (F)R(0.0));
}

/// The four texels around a position and their weights.
typedef struct {
  uint column, next_column, row;  // rows `row` and `row` + 1
  real fx, fy;                    // weights of next_column and of row + 1
} EnvironmentTexels;

FN EnvironmentTexels environment_texels(real x, real y, uint width, uint height) {
  EnvironmentTexels t;
  t.column = min((uint)x, width - 1);
  t.next_column = t.column + 1 == width ? 0 : t.column + 1;
  t.row = min((uint)y, height - 2);
  t.fx = x - (real)t.column;
  t.fy = y - (real)t.row;
  return t;
}

#endif

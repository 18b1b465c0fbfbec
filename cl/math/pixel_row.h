// pixel_row.h - V neighbours along a row of pixels, stored in the slots of 4 x 4 blocks (shared/layout.h).
#ifndef SIMULI_CL_MATH_PIXEL_ROW_H
#define SIMULI_CL_MATH_PIXEL_ROW_H
#include "math/lanes.h"
#include "shared/layout.h"

#if V > SIM_BLOCK_SIDE
#define SIM_OF_BLOCK(at, k) vload4(0, (at) + (k)*SIM_RAY_BLOCK)
#endif

/// at: slot of the first pixel, whose column is a multiple of V.
FN F load_pixel_row(__global const real* at) {
#if V == 16
  return (F)(SIM_OF_BLOCK(at, 0), SIM_OF_BLOCK(at, 1), SIM_OF_BLOCK(at, 2), SIM_OF_BLOCK(at, 3));
#elif V == 8
  return (F)(SIM_OF_BLOCK(at, 0), SIM_OF_BLOCK(at, 1));
#else
  return LDV(at);
#endif
}

FN void store_pixel_row(__global real* at, F values) {
#if V == 16
  vstore4(values.s0123, 0, at);
  vstore4(values.s4567, 0, at + SIM_RAY_BLOCK);
  vstore4(values.s89ab, 0, at + 2 * SIM_RAY_BLOCK);
  vstore4(values.scdef, 0, at + 3 * SIM_RAY_BLOCK);
#elif V == 8
  vstore4(values.lo, 0, at);
  vstore4(values.hi, 0, at + SIM_RAY_BLOCK);
#else
  STV(at, values);
#endif
}

#endif

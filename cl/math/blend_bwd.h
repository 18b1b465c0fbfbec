// blend_bwd.h - what blending takes back, ray by ray: render_bwd_*.cl in order of range and light_bwd.h in rays' own
// orders include this one text, so that their gradients are the same bits where the orders are the same.
#ifndef SIMULI_CL_MATH_BLEND_BWD_H
#define SIMULI_CL_MATH_BLEND_BWD_H
#include "math/tile.h"

// Reals of replayed[] for each place of a tile's list: weights of all rays, then their gradients of ln alpha.
#define SIM_REPLAYED (2 * SIM_WALK_RAYS)

/// g . (features, distance and transmittance) of the whole ray: what is still to come before anything is blended.
/// out, grad_out: those of render_bwd(), from the vector's first slot on.
FN F behind_of(__global const real* out, __global const real* grad_out, uint slots) {
  // The stored features hold T times the background already.
  F behind = LDV(grad_out) * LDV(out);
  behind = fma(LDV(grad_out + slots), LDV(out + slots), behind);
  behind = fma(LDV(grad_out + 2 * slots), LDV(out + 2 * slots), behind);
  behind = fma(LDV(grad_out + SIM_O_TRANSMITTANCE * slots), LDV(out + SIM_O_TRANSMITTANCE * slots), behind);
  return fma(LDV(grad_out + SIM_O_DISTANCE * slots), LDV(out + SIM_O_DISTANCE * slots), behind);
}

/// dL/d ln alpha of what rays with `transmittance` left blend; value: g . (its features, its tau). `behind` loses what
/// it adds: dL/dalpha = T value - behind / (1 - alpha). None through the clamp, which `met` leaves out, too.
FN F log_alpha_gradient(I met, F alpha, F weight, F transmittance, F value, F* behind) {
  *behind = fma(-weight, value, *behind);
  const F d_alpha = fma(transmittance, value, -(*behind / (R(1.0) - alpha)));
  return SEL(AND(met, alpha < SIM_ALPHA_MAX), d_alpha * alpha, (F)R(0.0));
}

#endif

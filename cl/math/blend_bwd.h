// blend_bwd.h - backward pass of blending for each ray. render_bwd_*.cl (order of range) and light_bwd.h (each
// ray's own order) include this one text, so that gradients have the same bits where the orders are equal.
#ifndef SIMULI_CL_MATH_BLEND_BWD_H
#define SIMULI_CL_MATH_BLEND_BWD_H
#include "math/tile.h"

// Reals of replayed[] per entry of a tile's list: weights of all rays, then gradients of their ln alpha.
#define SIM_REPLAYED (2 * SIM_WALK_RAYS)

/// Returns g . (features, distance and transmittance) of the whole ray, the remaining contribution before
/// anything is blended. out, grad_out: as in render_bwd(), from the vector's first slot on.
FN F behind_of(__global const real* out, __global const real* grad_out, uint slots) {
  // The stored features already contain T times the background.
  F behind = LDV(grad_out) * LDV(out);
  behind = fma(LDV(grad_out + slots), LDV(out + slots), behind);
  behind = fma(LDV(grad_out + 2 * slots), LDV(out + 2 * slots), behind);
  behind = fma(LDV(grad_out + SIM_O_TRANSMITTANCE * slots), LDV(out + SIM_O_TRANSMITTANCE * slots), behind);
  return fma(LDV(grad_out + SIM_O_DISTANCE * slots), LDV(out + SIM_O_DISTANCE * slots), behind);
}

/// Returns dL/d ln alpha of a response blended with `transmittance` left; value: g . (its features, its tau).
/// Subtracts its contribution from `behind`: dL/dalpha = T value - behind / (1 - alpha). No gradient passes the
/// clamp of alpha, which `met` excludes.
FN F log_alpha_gradient(I met, F alpha, F weight, F transmittance, F value, F* behind) {
  *behind = fma(-weight, value, *behind);
  const F d_alpha = fma(transmittance, value, -(*behind / (R(1.0) - alpha)));
  return SEL(AND(met, alpha < SIM_ALPHA_MAX), d_alpha * alpha, (F)R(0.0));
}

#endif

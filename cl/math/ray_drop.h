// ray_drop.h - ray-drop probability of a LiDAR ray from its blended outputs (METHOD section 7). Render and loss
// include this one text.
#ifndef SIMULI_CL_MATH_RAY_DROP_H
#define SIMULI_CL_MATH_RAY_DROP_H
#include "math/elementary.h"
#include "shared/sensor_constants.h"

#define DROP_SCALE R(10.0)       // scale of inputs that are shares, so that Adam's steps suit all inputs
#define DROP_HALF_RANGE R(20.0)  // m

/// Inputs of the function from a ray's outputs: drop logit minus hit logit; and ten times transmittance,
/// intensity, and D / (D + 20 m) with the distance D, the latter two relative to the ray's opacity. The last
/// two pass no gradient, because returns supervise geometry and intensity.
FN void drop_inputs(F intensity, F hit, F drop, F transmittance, F distance, F* x) {
  const F opacity = R(1.0) - transmittance;
  const F reach = distance + DROP_HALF_RANGE * opacity;
  x[0] = drop - hit;
  x[1] = DROP_SCALE * transmittance;
  x[2] = DROP_SCALE * intensity;
  x[3] = DROP_SCALE * opacity * distance / SEL(reach > R(0.0), reach, (F)R(1.0));
}

/// A hidden value a / (1 + |a|) of a weighted sum a of the inputs; slope: its derivative by a.
FN F drop_hidden(__global const DropConstants* f, int k, const F* x, F* slope) {
  const __global real* w = f->hidden + k * (SIM_DROP_INPUTS + 1);
  F a = (F)w[SIM_DROP_INPUTS];
  for (int j = 0; j < SIM_DROP_INPUTS; ++j) a = fma((F)w[j], x[j], a);
  const F inv = R(1.0) / (R(1.0) + fabs(a));
  *slope = inv * inv;
  return a * inv;
}

/// ln(p / (1 - p)) with p the probability of no return.
FN F drop_logit(__global const DropConstants* f, const F* x) {
  F logit = (F)f->bias, slope;
  for (int j = 0; j < SIM_DROP_INPUTS; ++j) logit = fma((F)f->skip[j], x[j], logit);
  for (int k = 0; k < SIM_DROP_HIDDEN; ++k) logit = fma((F)f->out[k], drop_hidden(f, k, x, &slope), logit);
  return logit;
}

/// The same from a ray's blended outputs.
FN F drop_of(__global const DropConstants* f, F intensity, F hit, F drop, F transmittance, F distance) {
  F x[SIM_DROP_INPUTS];
  drop_inputs(intensity, hit, drop, transmittance, distance, x);
  return drop_logit(f, x);
}

#endif

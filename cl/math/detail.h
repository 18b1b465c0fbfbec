// detail.h - how much of particles is there at their distance (METHOD section 4, level of detail).
// Build: DETAIL = 1 when particles have levels.
#ifndef SIMULI_CL_MATH_DETAIL_H
#define SIMULI_CL_MATH_DETAIL_H
#include "math/elementary.h"
#include "shared/layout.h"
#include "shared/sensor_constants.h"

/// 0 up to `distance`, 1 from SIM_DETAIL_FADE times that on.
FN F faded_in(F range, F distance) {
  const F t = (range - distance) / ((R(SIM_DETAIL_FADE) - R(1.0)) * distance);
  return VMAX(VMIN(t, (F)R(1.0)), (F)R(0.0));
}

/// How much of particles is there, `range` from the sensor: 0 to 1.
/// in  detail[SIM_DETAIL][stride] from particle i on
FN F share_of(__global const SensorConstants* sensor, __global const real* detail, uint stride, F range) {
  const F from = LDV(detail + SIM_DETAIL_FROM * stride), until = LDV(detail + SIM_DETAIL_UNTIL * stride);
  const F there = SEL(from > R(0.0), faded_in(range, sensor->detail_reach * from), (F)R(1.0));
  return there * (R(1.0) - faded_in(range, sensor->detail_reach * until));
}

/// -ln(sigma) of that much of particles: what gets past it is (1 - sigma)^share, so that those who come and those
/// who go are as opaque together as either.
FN F shared_out(F share, F bounded_logit, F opaque) {
  if (!ANY(share < R(1.0))) return opaque;
  const F stopped = R(1.0) - exp_lanes(-share * log(R(1.0) + exp_lanes(bounded_logit)));
  // A logarithm that is a number.
  return SEL(share < R(1.0), -log(VMAX(stopped, (F)R(1e-35))), opaque);
}

#endif

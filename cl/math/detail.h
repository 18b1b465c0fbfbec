// detail.h - fading of particles by distance (METHOD section 4, level of detail).
// Build: DETAIL = 1 when particles have levels.
#ifndef SIMULI_CL_MATH_DETAIL_H
#define SIMULI_CL_MATH_DETAIL_H
#include "math/elementary.h"
#include "shared/layout.h"
#include "shared/sensor_constants.h"

/// 0 up to `distance`, 1 from SIM_DETAIL_FADE times `distance` on.
FN F faded_in(F range, F distance) {
  const F t = (range - distance) / ((R(SIM_DETAIL_FADE) - R(1.0)) * distance);
  return VMAX(VMIN(t, (F)R(1.0)), (F)R(0.0));
}

/// Returns the share of particles present at distance `range` from the sensor, 0 to 1.
/// in  detail[SIM_DETAIL][stride] from particle i on
FN F share_of(__global const SensorConstants* sensor, __global const real* detail, uint stride, F range) {
  const F from = LDV(detail + SIM_DETAIL_FROM * stride), until = LDV(detail + SIM_DETAIL_UNTIL * stride);
  const F there = SEL(from > R(0.0), faded_in(range, sensor->detail_reach * from), (F)R(1.0));
  return there * (R(1.0) - faded_in(range, sensor->detail_reach * until));
}

/// Returns -ln(sigma) of a share of particles: the transmittance is (1 - sigma)^share, so that a level that
/// fades in and a level that fades out are together as opaque as either.
FN F shared_out(F share, F bounded_logit, F opaque) {
  if (!ANY(share < R(1.0))) return opaque;
  const F stopped = R(1.0) - exp_lanes(-share * log(R(1.0) + exp_lanes(bounded_logit)));
  // Keeps the logarithm finite.
  return SEL(share < R(1.0), -log(VMAX(stopped, (F)R(1e-35))), opaque);
}

#endif

// ray_feature.h - a particle's features as seen by V rays, each along its own direction.
// Build: RAY_SH = 1 enables them, then also CLAMPED_CHANNELS (cameras 3; LiDARs only the intensity); otherwise
// features come from the blending record and this file is empty. ACTOR_IDS = 1: a particle shows only its actor
// (0: none). The first feature is then the median distance, and the median's output the actor of the particle
// there; other features are undefined. ACTORS as in actor.h.
#ifndef SIMULI_CL_MATH_RAY_FEATURE_H
#define SIMULI_CL_MATH_RAY_FEATURE_H
#include "math/sh.h"
#include "shared/layout.h"
#include "shared/sensor_constants.h"

#ifndef RAY_SH
#define RAY_SH 0
#endif
#ifndef ACTOR_IDS
#define ACTOR_IDS 0
#endif

/// Sources of a particle's features.
typedef struct {
  __global const real* params;
  uint stride;
  __global const uint* actor_of;
  __global const ActorConstants* actors;
} Features;
FN Features features_of(__global const real* params,
                        uint stride,
                        __global const uint* actor_of,
                        __global const ActorConstants* actors) {
  const Features of = {params, stride, actor_of, actors};
  return of;
}

#if RAY_SH

/// feature[3] of one particle: SH along the unit directions d[3] of V rays, in its actor's axes at mid-frame.
/// Non-finite sums become 0.
FN void ray_feature(const Features* of, uint particle, const F* d, F* feature) {
  F towards[3] = {d[0], d[1], d[2]};
#if ACTORS
  const uint id = of->actor_of[particle];
  if (id != 0) {
    const __global real* r = of->actors[id].rotation;
    SIM_EACH(k, 3) towards[k] = d[0] * r[k] + d[1] * r[3 + k] + d[2] * r[6 + k];
  }
#endif
  F basis[SH_COEFFICIENTS];
  sh_basis(towards[0], towards[1], towards[2], basis);
  SIM_EACH(channel, 3) {
    F sum = (F)R(0.0);
    SIM_EACH(k, SH_COEFFICIENTS) {
      // clang 15 crashes on halves when this is one expression.
      const real coefficient = SH_ONE(of->params, of->stride, k, channel, particle);
      sum = fma(basis[k], (F)coefficient, sum);
    }
    sum = SEL(fabs(sum) < R(1e20), sum, (F)R(0.0));
    feature[channel] = channel < CLAMPED_CHANNELS ? VMAX(sum + R(0.5), (F)R(0.0)) : sum;
  }
}
#endif
#endif

// ray_feature.h - a particle's features as V rays see them, each along its own direction.
// Build: RAY_SH = 1 for them, then also CLAMPED_CHANNELS (of a camera 3, of a LiDAR the intensity alone); else
// features are those of the blending record, and nothing is here.
// ACTOR_IDS = 1: what is seen of a particle is its actor alone (0: none). The first feature is the median distance,
// which itself becomes the actor of the particle there; the other features mean nothing. ACTORS as actor.h.
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

/// Where a particle's features come from.
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

/// feature[3] of one particle: SH along the unit directions d[3] of V rays, in the axes that its actor has
/// half-way through the frame. Sums that floats do not hold become 0.
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
      // In one step, clang 15 crashes over halves.
      const real coefficient = SH_ONE(of->params, of->stride, k, channel, particle);
      sum = fma(basis[k], (F)coefficient, sum);
    }
    sum = SEL(fabs(sum) < R(1e20), sum, (F)R(0.0));
    feature[channel] = channel < CLAMPED_CHANNELS ? VMAX(sum + R(0.5), (F)R(0.0)) : sum;
  }
}
#endif
#endif

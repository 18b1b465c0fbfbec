// response.h - response of V rays to one particle. Forward and backward blending include this one text, so that
// they round alike and agree on the contributing rays.
// Build: ORIGINS = 1 when rays have individual origins (shutter, spin, lever arms); ACTOR_MOTION as in actor.h.
#ifndef SIMULI_CL_MATH_RESPONSE_H
#define SIMULI_CL_MATH_RESPONSE_H
#include "math/elementary.h"
#include "shared/layout.h"

// sigma may round to 1: the clamp keeps 1 - alpha away from 0.
#define SIM_ALPHA_MAX R(0.999)

/// Rays of one vector.
typedef struct {
  F d[3];  // unit direction; zero: no ray, or a terminated one
#if ORIGINS
  F o[3];  // origin - o_ref, m
#endif
#if ACTOR_MOTION
  F t;  // share of the frame
#endif
  F u;  // position along the tile's x axis: px, or unrolled spin angle in rad
} RayLanes;

typedef struct {
  F a[3];  // direction in the particle's frame, scaled by 1 / r
#if ORIGINS
  F o[3];  // origin in that frame (else 0, 0, -1)
#endif
  F inv_n;   // 1 / |a|^2
  F tau;     // m, distance of the maximum response along the ray
  F q;       // squared distance there
  I inside;  // contributes, apart from termination
} Response;

/// record: the particle's 16 reals; box_mean: the nearer to the tile of its two positions.
FN void respond(
    const real* record, real box_mean, const RayLanes* ray, real t_min, real t_max, Response* out) {
  // The first row's third entry is 0.
  out->a[0] = fma(ray->d[0], (F)record[0], ray->d[1] * record[1]);
  out->a[1] = fma(ray->d[0], (F)record[2], fma(ray->d[1], (F)record[3], ray->d[2] * record[4]));
  out->a[2] = fma(ray->d[0], (F)record[5], fma(ray->d[1], (F)record[6], ray->d[2] * record[7]));
#if ORIGINS
  out->o[0] = fma(ray->o[0], (F)record[0], ray->o[1] * record[1]);
  out->o[1] = fma(ray->o[0], (F)record[2], fma(ray->o[1], (F)record[3], ray->o[2] * record[4]));
  out->o[2] =
      fma(ray->o[0], (F)record[5], fma(ray->o[1], (F)record[6], fma(ray->o[2], (F)record[7], (F)R(-1.0))));
  // |o x a|^2 by the cross product: it does not cancel.
  const F cx = fma(out->o[1], out->a[2], -(out->o[2] * out->a[1]));
  const F cy = fma(out->o[2], out->a[0], -(out->o[0] * out->a[2]));
  const F cz = fma(out->o[0], out->a[1], -(out->o[1] * out->a[0]));
  const F cross2 = fma(cx, cx, fma(cy, cy, cz * cz));
  const F n = fma(out->a[0], out->a[0], fma(out->a[1], out->a[1], out->a[2] * out->a[2]));
  const F dot = fma(out->o[0], out->a[0], fma(out->o[1], out->a[1], out->o[2] * out->a[2]));
  out->inv_n = R(1.0) / n;
  out->tau = -dot * out->inv_n;
#else
  const F cross2 = fma(out->a[0], out->a[0], out->a[1] * out->a[1]);
  const F n = fma(out->a[2], out->a[2], cross2);
  out->inv_n = R(1.0) / n;
  out->tau = out->a[2] * out->inv_n;
#endif
  out->q = cross2 * out->inv_n * record[SIM_R_RADIUS2];
  // A zero direction makes q and tau NaN: every comparison is false.
  const I in_box = fabs(ray->u - box_mean) <= record[SIM_R_BOX_HALF];
  const I in_reach = out->q <= record[SIM_R_QMAX];
  out->inside = AND(AND(in_box, in_reach), AND(out->tau > t_min, out->tau < t_max));
}

/// alpha before the clamp: sigma exp(-q/2) = cut exp((qmax - q)/2).
FN F raw_alpha(const real* record, F q, real log_cut) {
  return exp_lanes(fma(record[SIM_R_QMAX] - q, (F)R(0.5), (F)log_cut));
}

/// Returns the nearer to u of a record's two positions along x; u: any position in the tile.
FN real nearest_box_mean(const real* record, real u) {
  const real one = record[SIM_R_BOX_MEAN], other = record[SIM_R_BOX_OTHER];
  return fabs(other - u) < fabs(one - u) ? other : one;
}

/// Clamped alpha of the rays `inside`; 0 for others.
FN F alpha_of(I inside, const real* record, F q, real log_cut) {
  return SEL(inside, VMIN(raw_alpha(record, q, log_cut), (F)SIM_ALPHA_MAX), (F)R(0.0));
}

// Through a pointer: Mesa's rusticl loses structures assigned to array elements.
FN void load_ray(
    __global const real* world_ray, __global const real* ray_u, uint slots, uint slot, RayLanes* ray) {
  SIM_EACH(k, 3) ray->d[k] = LDV(world_ray + k * slots + slot);
#if ORIGINS
  SIM_EACH(k, 3) ray->o[k] = LDV(world_ray + (3 + k) * slots + slot);
#endif
#if ACTOR_MOTION
  ray->t = LDV(world_ray + 6 * slots + slot);
#endif
  ray->u = LDV(ray_u + slot);
}

#if ACTOR_MOTION
/// Transforms the ray by the inverse of the particle's motion between the record's time and the ray's time.
/// Exact except for the actor's rotation in between.
FN void follow(const RayLanes* ray, const real* motion, RayLanes* seen) {
  // Member by member: copying the whole struct is a function call on CPUs, around which no register keeps the
  // particle's record.
  const F dt = ray->t - motion[SIM_M_TIME];
  SIM_EACH(k, 3) {
    seen->d[k] = ray->d[k];
    seen->o[k] = fma(dt, (F)-motion[SIM_M_VELOCITY + k], ray->o[k]);
  }
  seen->t = ray->t;
  seen->u = ray->u;
}
#endif

#endif

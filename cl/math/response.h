// response.h - what one particle does to V rays. Forward and backward blending include this one text, so
// that they round alike and agree on who contributes.
// Build: ORIGINS = 1 when rays have origins of their own (shutter, spin, lever arms).
#ifndef SIMULI_CL_MATH_RESPONSE_H
#define SIMULI_CL_MATH_RESPONSE_H
#include "math/elementary.h"
#include "shared/layout.h"

// sigma is not 1 to the last bit: a clamp keeps 1 - alpha away from 0.
#define ALPHA_MAX R(0.999)

/// Rays of one vector.
typedef struct {
  F d[3];  // unit direction; zero: no ray, or one that is done
#if ORIGINS
  F o[3];  // origin - o_ref, m
#endif
  F u;     // place along the tile's x axis, from the tile's own origin
} RayLanes;

typedef struct {
  F a[3];      // direction in the particle's frame, scaled by 1 / r
#if ORIGINS
  F o[3];      // origin in that frame (else 0, 0, -1)
#endif
  F inv_n;     // 1 / |a|^2
  F tau;       // m, place of the maximum response along the ray
  F q;         // squared distance there
  I inside;    // contributes, but for retirement
} Response;

/// record: the particle's 16 reals, its box mean already relative to the tile's origin.
FN void respond(const real* record, real box_mean, const RayLanes* ray, real t_min, real t_max, Response* out) {
  for (int k = 0; k < 3; ++k) {
    const real* row = record + 3 * k;
    out->a[k] = fma(ray->d[0], (F)row[0], fma(ray->d[1], (F)row[1], ray->d[2] * row[2]));
  }
#if ORIGINS
  for (int k = 0; k < 3; ++k) {
    const real* row = record + 3 * k;
    const F rest = k == 2 ? (F)R(-1.0) : (F)R(0.0);
    out->o[k] = fma(ray->o[0], (F)row[0], fma(ray->o[1], (F)row[1], fma(ray->o[2], (F)row[2], rest)));
  }
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

/// Box mean of a record from the origin of tile column tx, by the shorter way round.
FN real local_box_mean(real box_mean, uint tx, __global const real* sensor) {
  real mean = box_mean;
  if (sensor[SIM_S_PERIOD] > R(0.0)) {
    mean -= sensor[SIM_S_TILE_X0] + ((real)tx + R(0.5)) / sensor[SIM_S_TILE_SCALE];
    mean -= sensor[SIM_S_PERIOD] * rint(mean / sensor[SIM_S_PERIOD]);
  }
  return mean;
}

// Slots of vector j of this work-item, from the tile's first slot, and its slot row.
#define VECTOR_SLOT(j, lid) (((j) * LS + (lid)) * V)
#define VECTOR_SLOT_ROW(j, lid) (VECTOR_SLOT(j, lid) / SIM_SLOT_ROW)
#define SLOT_ROW_FIRST(payload) ((payload) >> SIM_PARTICLE_BITS & 15u)
#define SLOT_ROW_LAST(payload) ((payload) >> (SIM_PARTICLE_BITS + 4))

// The vectors of this work-item that a slot-row range touches: [J_FIRST, J_LAST]. With one work-item per
// tile they are consecutive; else every vector is tested.
#if LS == 1
#define J_FIRST(payload) ((int)(SLOT_ROW_FIRST(payload) * (SIM_SLOT_ROW / V)))
#define J_LAST(payload) ((int)(SLOT_ROW_LAST(payload) * (SIM_SLOT_ROW / V)) + SIM_SLOT_ROW / V - 1)
#define J_OUTSIDE(j, lid, payload) 0
#else
#define J_FIRST(payload) 0
#define J_LAST(payload) (NR - 1)
#define J_OUTSIDE(j, lid, payload)                          \
  (VECTOR_SLOT_ROW(j, lid) < SLOT_ROW_FIRST(payload) ||     \
   VECTOR_SLOT_ROW(j, lid) > SLOT_ROW_LAST(payload))
#endif

FN RayLanes load_ray(__global const real* world_ray, __global const real* ray_u, uint slots, uint slot) {
  RayLanes ray;
  for (int k = 0; k < 3; ++k) ray.d[k] = LDV(world_ray + k * slots + slot);
#if ORIGINS
  for (int k = 0; k < 3; ++k) ray.o[k] = LDV(world_ray + (3 + k) * slots + slot);
#endif
  ray.u = LDV(ray_u + slot);
  return ray;
}

#endif

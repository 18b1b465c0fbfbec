// actor.h - poses of the actors that V particles belong to (METHOD section 2).
// Build: ACTORS = 1 when particles may belong to actors, ACTOR_MOTION = 1 when actors move during the frame,
// DEFORM = 1 when some actor is not rigid.
#ifndef SIMULI_CL_MATH_ACTOR_H
#define SIMULI_CL_MATH_ACTOR_H
#include "math/elementary.h"
#include "math/rotation.h"
#include "shared/layout.h"
#include "shared/sensor_constants.h"

#ifndef ACTORS
#define ACTORS 0
#endif
#ifndef ACTOR_MOTION
#define ACTOR_MOTION 0
#endif
#ifndef DEFORM
#define DEFORM 0
#endif

#if ACTORS
/// scene_from_actor of V lanes at one time of the frame. Background lanes have the identity rotation and do not
/// move.
typedef struct {
  int any;        // some lane belongs to an actor; otherwise the members below are not set
  I on;           // lanes of actors
  F there;        // factor of their opacity: 0 for an actor absent from the frame, 1 for the background
  F centre[3];    // actor's origin minus o_ref, m
  F rotation[9];  // row-major
#if DEFORM
  F reach;  // largest offset of particles by deformation, m
#endif
#if ACTOR_MOTION
  F step[3];  // origin at the end minus origin at the start
  F axis[3];  // axis of the rotation from start to end, scene axes
  F angle;    // angle of that rotation, rad
#endif
} ActorLanes;

/// Loads the actors of particles i .. i+V-1 at mid-frame.
/// in  actor_of[stride]: 0 or 1 + the actor; actors[1 + A]
FN void load_actors(__global const uint* actor_of,
                    __global const ActorConstants* actors,
                    uint i,
                    ActorLanes* a) {
  uint ids = 0;
  SIM_EACH(lane, V) ids |= actor_of[i + lane];
  a->any = ids != 0;
  if (!a->any) return;
  real on[V], there[V], centre[3 * V], rotation[9 * V];
#if DEFORM
  real reach[V];
#endif
#if ACTOR_MOTION
  real step[3 * V], axis[3 * V], angle[V];
#endif
  SIM_EACH(lane, V) {
    const uint id = actor_of[i + lane];
    __global const ActorConstants* actor = actors + id;
    on[lane] = id != 0 ? R(1.0) : R(0.0);
    there[lane] = actor->there;
    SIM_EACH(k, 3) centre[k * V + lane] = actor->centre[k];
    SIM_EACH(k, 9) rotation[k * V + lane] = actor->rotation[k];
#if DEFORM
    reach[lane] = actor->reach;
#endif
#if ACTOR_MOTION
    SIM_EACH(k, 3) step[k * V + lane] = actor->step[k];
    SIM_EACH(k, 3) axis[k * V + lane] = actor->turn_axis[k];
    angle[lane] = actor->turn_angle;
#endif
  }
  a->on = LDV(on) > R(0.5);
  a->there = LDV(there);
  SIM_EACH(k, 3) a->centre[k] = LDV(centre + k * V);
  SIM_EACH(k, 9) a->rotation[k] = LDV(rotation + k * V);
#if DEFORM
  a->reach = LDV(reach);
#endif
#if ACTOR_MOTION
  SIM_EACH(k, 3) a->step[k] = LDV(step + k * V);
  SIM_EACH(k, 3) a->axis[k] = LDV(axis + k * V);
  a->angle = LDV(angle);
#endif
}

#if ACTOR_MOTION
/// The actors' rotation from mid-frame to time t, row-major (Rodrigues).
FN void actor_turn(const ActorLanes* a, F t, F* m) {
  F sine, cosine;
  sincos_lanes(a->angle * (t - R(0.5)), &sine, &cosine);
  const F rest = R(1.0) - cosine;
  SIM_EACH(i, 3) {
    SIM_EACH(j, 3) m[3 * i + j] = rest * a->axis[i] * a->axis[j];
    m[4 * i] += cosine;
  }
  const F x = a->axis[0] * sine, y = a->axis[1] * sine, z = a->axis[2] * sine;
  m[1] -= z;
  m[2] += y;
  m[3] += z;
  m[5] -= x;
  m[6] -= y;
  m[7] += x;
}

/// Position at time t, minus o_ref, of the point at o_ref + p at mid-frame; `turn` from actor_turn for that
/// time.
FN void actor_carry(const ActorLanes* a, const F* turn, F t, const F* p, F* out) {
  const F arm[3] = {p[0] - a->centre[0], p[1] - a->centre[1], p[2] - a->centre[2]};
  F turned[3];
  rotate_lanes(turn, arm, turned);
  SIM_EACH(k, 3) {
    out[k] = SEL(a->on, a->centre[k] + a->step[k] * (t - R(0.5)) + turned[k], p[k]);
  }
}

/// Largest displacement in m during the frame of points within `radius` of o_ref + p; 0 at rest.
FN F actor_travel(const ActorLanes* a, const F* p, F radius) {
  F arm2 = (F)R(0.0), step2 = (F)R(0.0);
  SIM_EACH(k, 3) {
    const F arm = p[k] - a->centre[k];
    arm2 = fma(arm, arm, arm2);
    step2 = fma(a->step[k], a->step[k], step2);
  }
  return SEL(a->on, sqrt(step2) + a->angle * (sqrt(arm2) + radius), (F)R(0.0));
}
#endif
#endif

#endif

// cluster_culling.h - conservative visibility test of a cluster (METHOD section 4).
#ifndef SIMULI_CL_MATH_CLUSTER_CULLING_H
#define SIMULI_CL_MATH_CLUSTER_CULLING_H
#include "math/extent.h"
#include "shared/cluster.h"

// Largest difference by rounding between a particle's own test and its cluster's, as a share of the distance:
// twice the angle whose cosine float cannot distinguish from 1, sqrt(20 * 2^-24), doubled.
#define CLUSTER_MARGIN R(4e-3)

/// Returns false in lanes where may_be_seen() (project.cl) is false for every particle of the cluster, tested
/// with the bounding ball of all of them. Returns true where that is unknown: NaN keeps a cluster.
/// in  bounds[SIM_CLUSTER_ROWS][stride] from cluster i on; actor_of[stride], actors[1 + A] with ACTORS
FN I cluster_may_be_seen(const FrameParams* frame,
                         __global const SensorConstants* sensor,
                         __global const real* bounds,
                         __global const uint* actor_of,
                         __global const ActorConstants* actors,
                         uint stride,
                         uint i) {
  bounds += i;
  F offset[3];
  SIM_EACH(k, 3) offset[k] = LDV(bounds + (SIM_C_CENTRE + k) * stride) - sensor->centre_ref[k];
  F means = LDV(bounds + SIM_C_RADIUS * stride);
  I away = (F)R(0.0) != (F)R(0.0);
#if ACTORS
  ActorLanes actor;
  load_actors(actor_of, actors, i, &actor);
  if (actor.any) {
    F turned[3];
    const F centre[3] = {LDV(bounds + SIM_C_CENTRE * stride),
                         LDV(bounds + (SIM_C_CENTRE + 1) * stride),
                         LDV(bounds + (SIM_C_CENTRE + 2) * stride)};
    rotate_lanes(actor.rotation, centre, turned);
    SIM_EACH(k, 3) offset[k] = SEL(actor.on, actor.centre[k] + turned[k], offset[k]);
    away = actor.there <= R(0.0);
#if DEFORM
    means += SEL(actor.on, actor.reach, (F)R(0.0));
#endif
  }
#endif
  const F distance = sqrt(offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2]);
  const F farthest = distance + means;
  // Largest radius of a particle: its reach times its largest filtered scale.
  const F logit = VMAX(VMIN(LDV(bounds + SIM_C_OPACITY * stride), (F)R(80.0)), (F)R(-80.0));
  const F qmax = R(1e-3) - R(2.0) * (log(R(1.0) + exp_lanes(-logit)) + log(sensor->alpha_cut));
  const F scale = exp_lanes(LDV(bounds + SIM_C_LOG_SCALE * stride));
  const F widest = sqrt(fma(scale, scale, farthest * farthest * sensor->model.kappa));
  const F radius = R(1.001) * sqrt(VMAX(qmax, (F)R(0.0))) * widest;
  F travel = (F)R(0.0);
#if ACTOR_MOTION
  if (actor.any) travel = actor_travel(&actor, offset, means + radius);
#endif
  F ball = means + radius + R(0.5) * travel + CLUSTER_MARGIN * farthest;
  away = OR(away, OR(qmax <= R(0.0), distance - ball >= sensor->model.t_max + origin_reach(frame, sensor)));
#if DETAIL
  // All particles not yet present, or all gone.
  const F slack = means + CLUSTER_MARGIN * farthest;
  away = OR(away, distance + slack <= sensor->detail_reach * LDV(bounds + SIM_C_FROM * stride));
  const F gone = (R(SIM_DETAIL_FADE) * sensor->detail_reach) * LDV(bounds + SIM_C_UNTIL * stride);
  away = OR(away, distance - slack >= gone);
#endif
#if SENSOR == SENSOR_CAMERA
  F centre[3];
  sensor_from_world_point(sensor, offset, (F)R(0.5), centre);
  ball += R(0.5) * centre_path(sensor);
  const F tangent2 = fma(distance, distance, -(ball * ball));
  const F tangent = sqrt(VMAX(tangent2, (F)R(0.0)));
  const F limit = fma(tangent, (F)sensor->cos_view, ball * -sensor->sin_view);
  const I part_way = fma(tangent, (F)sensor->sin_view, ball * sensor->cos_view) > R(0.0);
  away = OR(away, AND(AND(tangent2 > R(0.0), part_way), centre[2] < limit));
#endif
  return NOT(away);
}

#endif

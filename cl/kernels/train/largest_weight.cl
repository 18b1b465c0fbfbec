// largest_weight.cl - the largest weight of each particle in any ray. Launcher: host/render/train/largest_weight.cpp
#include "math/response.h"

/// Blends as render does, and keeps of each particle the largest weight that it has had in a ray. Weights are
/// at least 0, so that their bits rise with them: the maximum is one of whole numbers, whose order does not
/// matter.
/// in  as render
/// out largest[N]: bits of a float each, not below what they were before
__kernel GROUP void largest_weight(const FrameParams frame,
                             __global const SensorConstants* sensor,
                             __global const real* world_ray,
                             __global const real* ray_u,
                             __global const uint* first,
                             __global const uint* payload,
                             __global const real* records,
                             __global const real* motions,
                             __global uint* largest) {
  const uint tile = get_group_id(0);
  const uint lid = get_local_id(0);
  const uint base = tile * TILE_RAYS;
  const real tile_u = ray_u[base];
  const real t_min = sensor->model.t_min;
  const real t_max = sensor->model.t_max;
  const real t_cut = sensor->transmittance_cut;
  const real log_cut = log(sensor->alpha_cut);

  RayLanes ray[NR];
  F transmittance[NR];
  uint alive = 0;  // a bit per vector that still has a ray
  EACH_VECTOR
  for (int j = 0; j < NR; ++j) {
    load_ray(world_ray, ray_u, frame.slots, base + VECTOR_SLOT(j, lid), &ray[j]);
    transmittance[j] = (F)R(1.0);
    alive |= (ANY(is_ray(ray[j].d[0], ray[j].d[1], ray[j].d[2])) ? 1u : 0u) << j;
  }

  const uint end = first[tile + 1];
  for (uint i = first[tile]; i < end && alive; ++i) {
    const uint packed = payload[i];
    const uint particle = packed & SIM_PARTICLE_MASK;
    real record[SIM_RECORD];
    load_record(records + (ulong)particle * SIM_RECORD, record);
#if ACTOR_MOTION
    real motion[SIM_MOTION];
    const int moves = take_motion(record, motions, particle, motion);
#endif
    const real box_mean = nearest_box_mean(record, tile_u);
    F most = (F)R(0.0);
    const int j_last = J_LAST(packed);
    EACH_VECTOR
    for (int j = J_FIRST(packed); j <= j_last; ++j) {
      if (J_OUTSIDE(j, lid, packed) || !(alive >> j & 1u)) continue;
      RayLanes seen = ray[j];
#if ACTOR_MOTION
      if (moves) seen = follow(&ray[j], motion);
#endif
      Response response;
      respond(record, box_mean, &seen, t_min, t_max, &response);
      if (!ANY(response.inside)) continue;
      const F raw = raw_alpha(record, response.q, log_cut);
      const F weight = SEL(response.inside, VMIN(raw, (F)ALPHA_MAX), (F)R(0.0)) * transmittance[j];
      most = VMAX(most, weight);
      transmittance[j] -= weight;
      const I done = AND(transmittance[j] < t_cut, response.inside);
      if (ANY(done)) {
        for (int k = 0; k < 3; ++k) ray[j].d[k] = SEL(done, (F)R(0.0), ray[j].d[k]);
        const I going = is_ray(ray[j].d[0], ray[j].d[1], ray[j].d[2]);
        if (!ANY(going)) alive &= ~(1u << j);
      }
    }
    const uint bits = as_uint((float)HMAX(most));
    // Not read beforehand: others write it meanwhile.
    if (bits > 0) atomic_max(largest + particle, bits);
  }
}

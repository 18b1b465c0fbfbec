// render.cl - front-to-back blending of a tile's particles. Launcher: host/render/frame/render.cpp
#include "math/ray_drop.h"
#include "math/ray_feature.h"
#include "math/response.h"

/// One work-group of LS work-items per tile; each holds NR vectors of V rays in registers or L1.
/// in  world_ray[3|6|7][slots], ray_u[slots], of every slot a place in its tile; first[tiles+1]; payload[K] by
///     tile, nearest first; records[N][16]; motions[N][4] of particles that move, with ACTOR_MOTION
/// out out[7][slots]: 3 features over the background, transmittance, sum of w tau (m), median distance (m,
///     0 where transmittance never falls to 1/2; with ACTOR_IDS the actor there), with DROP the drop logit. Slots
///     without a ray get the background.
/// Particle outer, rays inner: the particle's record is read once per tile and only the slot rows that its
/// footprint touches are visited, of these the vectors that still have a ray. A ray is retired (direction
/// zeroed) once T < transmittance cut.
__kernel GROUP void render(const FrameParams frame,
                     __global const SensorConstants* sensor,
                     __global const real* world_ray,
                     __global const real* ray_u,
                     __global const uint* first,
                     __global const uint* payload,
                     __global const real* records,
                     __global const real* motions,
                     __global const real* params,
                     __global const uint* actor_of,
                     __global const ActorConstants* actors,
                     __global real* out) {
  const uint tile = get_group_id(0);
  const uint lid = get_local_id(0);
  const uint base = tile * TILE_RAYS;
  const real tile_u = ray_u[base];
  const real t_min = sensor->model.t_min;
  const real t_max = sensor->model.t_max;
  const real t_cut = sensor->transmittance_cut;
  const real log_cut = log(sensor->alpha_cut);

  RayLanes ray[NR];
  F transmittance[NR], f0[NR], f1[NR], f2[NR], distance[NR];
#if MEDIAN
  F median[NR];
#endif
  uint alive = 0;  // a bit per vector that still has a ray
  EACH_VECTOR
  for (int j = 0; j < NR; ++j) {
    load_ray(world_ray, ray_u, frame.slots, base + VECTOR_SLOT(j, lid), &ray[j]);
    transmittance[j] = (F)R(1.0);
    f0[j] = f1[j] = f2[j] = distance[j] = (F)R(0.0);
#if MEDIAN
    median[j] = (F)R(0.0);
#endif
    alive |= (ANY(is_ray(ray[j].d[0], ray[j].d[1], ray[j].d[2])) ? 1u : 0u) << j;
  }

  const uint end = first[tile + 1];
#if LS > 1
  __local REAL_VECTOR(4) staged[STAGED_RECORDS];
  __local uint staged_payload[LS];
  __local int group_alive;
  for (uint batch = first[tile]; batch < end; batch += LS) {
    barrier(CLK_LOCAL_MEM_FENCE);
    if (lid == 0) group_alive = 0;
    if (batch + lid < end) {
      const uint p = payload[batch + lid];
      staged_payload[lid] = p;
      stage_record(records + (ulong)(p & SIM_PARTICLE_MASK) * SIM_RECORD, staged, lid);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    if (alive) group_alive = 1;
    barrier(CLK_LOCAL_MEM_FENCE);
    if (!group_alive) break;
    const uint count = min((uint)LS, end - batch);
    for (uint i = 0; i < count; ++i) {
      const uint packed = staged_payload[i];
      real record[SIM_RECORD];
      staged_record(staged, i, record);
#else
  for (uint i = first[tile]; i < end && alive; ++i) {
    {
      const uint packed = payload[i];
      if (!(alive & VECTORS_OF(packed))) continue;  // its record is not even read
      if (i + AHEAD < end) PREFETCH(records + (ulong)(payload[i + AHEAD] & SIM_PARTICLE_MASK) * SIM_RECORD);
      real record[SIM_RECORD];
      load_record(records + (ulong)(packed & SIM_PARTICLE_MASK) * SIM_RECORD, record);
#endif
#if ACTOR_MOTION
      real motion[SIM_MOTION];
      const int moves = take_motion(record, motions, packed & SIM_PARTICLE_MASK, motion);
#endif
      const real box_mean = nearest_box_mean(record, tile_u);
      const int j_last = J_LAST(packed);
      EACH_VECTOR
      for (int j = J_FIRST(packed); j <= j_last; ++j) {
        if (J_OUTSIDE(j, lid, packed) || !(alive >> j & 1u)) continue;
#if LS > 1
        RayLanes followed = ray[j];  // a value: in registers
        const RayLanes* seen = &followed;
#else
        const RayLanes* seen = &ray[j];  // copies make a CPU's backward pass 1.4 times as slow
#if ACTOR_MOTION
        RayLanes followed;
#endif
#endif
#if ACTOR_MOTION
        if (moves) {
          followed = follow(&ray[j], motion);
          seen = &followed;
        }
#endif
        Response response;
        respond(record, box_mean, seen, t_min, t_max, &response);
#if V == 1 || RAY_SH
        if (!ANY(response.inside)) continue;  // of vectors most are touched: guessing wrong costs more than no light
#endif
        const F raw = raw_alpha(record, response.q, log_cut);
        const F alpha = SEL(response.inside, VMIN(raw, (F)ALPHA_MAX), (F)R(0.0));
        const F weight = alpha * transmittance[j];
#if ACTOR_IDS
        const F actor = (F)(real)actor_of[packed & SIM_PARTICLE_MASK];
#elif RAY_SH
        F feature[3];
        ray_feature(params, frame.stride, packed & SIM_PARTICLE_MASK, actor_of, actors, ray[j].d, feature);
        f0[j] = fma(weight, feature[0], f0[j]);
        f1[j] = fma(weight, feature[1], f1[j]);
        f2[j] = fma(weight, feature[2], f2[j]);
#else
        f0[j] = fma(weight, (F)record[SIM_R_FEATURE], f0[j]);
        f1[j] = fma(weight, (F)record[SIM_R_FEATURE + 1], f1[j]);
        f2[j] = fma(weight, (F)record[SIM_R_FEATURE + 2], f2[j]);
#endif
        // Lanes outside may hold NaN or infinity in tau.
        const F tau = SEL(response.inside, response.tau, (F)R(0.0));
        distance[j] = fma(weight, tau, distance[j]);
        const F left = transmittance[j] - weight;
#if MEDIAN
#if ACTOR_IDS
        const F halfway = actor;
#else
        const F halfway = tau;
#endif
        median[j] = SEL(AND(transmittance[j] > R(0.5), left <= R(0.5)), halfway, median[j]);
#endif
        transmittance[j] = left;
        const I done = AND(left < t_cut, response.inside);
        if (ANY(done)) {
          for (int k = 0; k < 3; ++k) ray[j].d[k] = SEL(done, (F)R(0.0), ray[j].d[k]);
          const I going = is_ray(ray[j].d[0], ray[j].d[1], ray[j].d[2]);
          if (!ANY(going)) alive &= ~(1u << j);
        }
      }
    }
  }

  EACH_VECTOR
  for (int j = 0; j < NR; ++j) {
    __global real* slot = out + base + VECTOR_SLOT(j, lid);
    const F t = transmittance[j];
    f0[j] = fma(t, (F)sensor->background[0], f0[j]);
    f1[j] = fma(t, (F)sensor->background[1], f1[j]);
    f2[j] = fma(t, (F)sensor->background[2], f2[j]);
    STV(slot, f0[j]);
    STV(slot + frame.slots, f1[j]);
    STV(slot + 2 * frame.slots, f2[j]);
    STV(slot + SIM_O_TRANSMITTANCE * frame.slots, t);
    STV(slot + SIM_O_DISTANCE * frame.slots, distance[j]);
#if MEDIAN
    STV(slot + SIM_O_MEDIAN * frame.slots, median[j]);
#endif
#if DROP
    STV(slot + SIM_O_DROP * frame.slots, drop_of(&sensor->drop, f0[j], f1[j], f2[j], t, distance[j]));
#endif
  }
}

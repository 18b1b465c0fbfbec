// render.cl - blends a tile's particles front to back. Launcher: host/device/render/frame/render.cpp
#include "math/ray_drop.h"
#include "math/ray_feature.h"
#include "math/tile_walk.h"

/// Accumulated outputs of a work-item's vectors.
struct Blending {
  RayLanes ray[NR];
  F transmittance[NR], f0[NR], f1[NR], f2[NR], distance[NR];
#if MEDIAN
  F median[NR];
#endif
  Features features;
};

FN void blend_pair(const Tile* tile, const TilePair* at, uint* alive, struct Blending* b) {
  uint vectors = vectors_of(at->packed, tile->lid) & *alive;
  SIM_EACH_VECTOR_OF(j, vectors) {
    RayLanes own;
    Response response;
    meet(tile, at, seen_by(at, &b->ray[j], &own), &response);
    // Most vectors are touched, so a mispredicted branch costs more than evaluating no light.
#if V == 1 || RAY_SH
    if (!ANY(response.inside)) continue;
#endif
    const F weight = alpha_of(response.inside, at->record, response.q, tile->log_cut) * b->transmittance[j];
#if ACTOR_IDS
    const F actor = (F)(real)b->features.actor_of[at->particle];
#elif RAY_SH
    F feature[3];
    ray_feature(&b->features, at->particle, b->ray[j].d, feature);
    b->f0[j] = fma(weight, feature[0], b->f0[j]);
    b->f1[j] = fma(weight, feature[1], b->f1[j]);
    b->f2[j] = fma(weight, feature[2], b->f2[j]);
#else
    b->f0[j] = fma(weight, (F)at->record[SIM_R_FEATURE], b->f0[j]);
    b->f1[j] = fma(weight, (F)at->record[SIM_R_FEATURE + 1], b->f1[j]);
    b->f2[j] = fma(weight, (F)at->record[SIM_R_FEATURE + 2], b->f2[j]);
#endif
    // Lanes outside may contain NaN or infinity in tau.
    const F tau = SEL(response.inside, response.tau, (F)R(0.0));
    b->distance[j] = fma(weight, tau, b->distance[j]);
    const F left = b->transmittance[j] - weight;
#if MEDIAN
    const I is_half = AND(b->transmittance[j] > R(0.5), left <= R(0.5));
#if ACTOR_IDS
    b->f0[j] = SEL(is_half, tau, b->f0[j]);
    b->median[j] = SEL(is_half, actor, b->median[j]);
#else
    b->median[j] = SEL(is_half, tau, b->median[j]);
#endif
#endif
    b->transmittance[j] = left;
    terminate_ray(AND(left < tile->t_cut, response.inside), j, &b->ray[j], alive);
  }
}

/// Blends one tile per work-group of LS work-items; each work-item has NR vectors of V rays in registers or L1
/// cache. The outer loop runs over particles: a particle's record is read once per tile, and only ray blocks
/// inside its footprint with active rays are evaluated. A ray terminates early (zero direction) once T <
/// transmittance cut.
/// in  world_ray[3|6|7][slots]; ray_u[slots]: position along x; first[tiles+1]; payload[K] by tile, nearest
///     first; records[N][16]; motions[N][4] of moving particles with ACTOR_MOTION
/// out out[7][slots]: 3 features over the background, transmittance, sum of w tau (m), median distance (m, 0
///     where transmittance never falls to 1/2), with DROP the drop logit. With ACTOR_IDS the first feature is
///     the median distance over a background of 0, and the median's row has the actor there. Slots without a
///     ray get the background.
__kernel SIM_GROUP void render(const FrameParams frame,
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
  const Tile tile = tile_at(get_group_id(0), sensor, ray_u, first, payload, records, motions);
  struct Blending b;
  b.features = features_of(params, frame.stride, actor_of, actors);
  uint alive = 0;  // one bit per vector that still has an active ray
  SIM_EACH_VECTOR
  for (int j = 0; j < NR; ++j) {
    load_ray(world_ray, ray_u, frame.slots, tile.base + SIM_VECTOR_SLOT(j, tile.lid), &b.ray[j]);
    b.transmittance[j] = (F)R(1.0);
    b.f0[j] = b.f1[j] = b.f2[j] = b.distance[j] = (F)R(0.0);
#if MEDIAN
    b.median[j] = (F)R(0.0);
#endif
    alive |= alive_bit(&b.ray[j], j);
  }

  SIM_WALK(&tile, &alive, &b);

  SIM_EACH_VECTOR
  for (int j = 0; j < NR; ++j) {
    __global real* slot = out + tile.base + SIM_VECTOR_SLOT(j, tile.lid);
    const F t = b.transmittance[j];
    const F f0 = fma(t, (F)sensor->background[0], b.f0[j]);
    const F f1 = fma(t, (F)sensor->background[1], b.f1[j]);
    const F f2 = fma(t, (F)sensor->background[2], b.f2[j]);
    STV(slot, f0);
    STV(slot + frame.slots, f1);
    STV(slot + 2 * frame.slots, f2);
    STV(slot + SIM_O_TRANSMITTANCE * frame.slots, t);
    STV(slot + SIM_O_DISTANCE * frame.slots, b.distance[j]);
#if MEDIAN
    STV(slot + SIM_O_MEDIAN * frame.slots, b.median[j]);
#endif
#if DROP
    STV(slot + SIM_O_DROP * frame.slots, drop_of(&sensor->drop, f0, f1, f2, t, b.distance[j]));
#endif
  }
}

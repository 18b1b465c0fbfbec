// render_bwd_lanes.cl - gradients of blending for tiles of one work-item. Launcher: host/device/render/backward/render_bwd.cpp
#include "math/gradient_slot.h"
#include "math/response_bwd.h"

/// Replay state of a tile's vectors.
struct Blending {
  RayLanes ray[NR];
  F g0[NR], g1[NR], g2[NR], gd[NR];
#if ERRORS
  F error[NR];
#endif
#if RAY_ORDER
  uint to[NR];                    // end of the list entries that each vector processes
  __global const real* replayed;  // from the first entry of the list
#else
  F transmittance[NR];
  F behind[NR];  // g . (remaining features, distance and final transmittance)
#endif
};

/// Gradients that the rays of a tile add to a pair.
typedef struct {
  F grad[SIM_GRAD];
  F error;
} Sums;

/// Prefetches records and gradient slots of the next pairs: the particles of a tile are scattered in memory,
/// and waiting for them would take a third of the time.
FN void fetch_ahead(const Tile* tile, uint i, const SlotMap* map, __global const real* grads) {
  if (i + 8 < tile->end) {
    const uint particle = tile->payload[i + 8] & SIM_PARTICLE_MASK;
    SIM_PREFETCH(tile->records + (ulong)particle * SIM_RECORD);
    SIM_PREFETCH(map->footprints + particle);
    SIM_PREFETCH(map->slot_first + particle);
  }
  if (i + 4 < tile->end) {
    const uint particle = tile->payload[i + 4] & SIM_PARTICLE_MASK;
    SIM_PREFETCH(grads + SIM_GRAD * gradient_slot(map, particle));
  }
}

FN void add_pair(const Tile* tile, const TilePair* at, uint* alive, struct Blending* b, Sums* sums) {
  uint vectors = vectors_of(at->packed, tile->lid) & *alive;
  SIM_EACH_VECTOR_OF(j, vectors) {
    RayLanes own;
    Response response;
    const RayLanes* seen = seen_by(at, &b->ray[j], &own);
    meet(tile, at, seen, &response);
    if (!ANY(response.inside)) continue;
#if RAY_ORDER
    if (at->place >= b->to[j]) continue;
    const __global real* weights =
        b->replayed + (ulong)at->place * SIM_REPLAYED + SIM_VECTOR_SLOT(j, tile->lid);
    const F weight = LDV(weights);
    const F d_log = LDV(weights + SIM_WALK_RAYS);
#else
    F d_log;
    const F weight = blend_back(at->record,
                                &response,
                                tile->log_cut,
                                b->g0[j],
                                b->g1[j],
                                b->g2[j],
                                b->gd[j],
                                &b->transmittance[j],
                                &b->behind[j],
                                &d_log);
#endif
#if ERRORS
    sums->error = fma(weight, b->error[j], sums->error);
#endif
    add_gradients(
        at->record, seen, &response, weight, d_log, b->g0[j], b->g1[j], b->g2[j], b->gd[j], sums->grad);
#if !RAY_ORDER
    terminate_ray(AND(b->transmittance[j] < tile->t_cut, response.inside), j, &b->ray[j], alive);
#endif
  }
}

/// Replays render front to back with the stored result: the contribution behind a particle is the result minus
/// the sum so far. No atomics: the sums of a pair go to its own slot.
/// Build: ERRORS = 1 blends the rays' errors as well; RAY_ORDER = 1 for rays in their own order, replayed by
/// replay_window. Processes tiles from tile_first on.
/// in  as render; out[6][slots] of render; grad_out[5][slots]: dL/d(features, T, distance); with RAY_ORDER
///     replayed[places][2][SIM_WALK_RAYS] and replayed_to[tiles][LS][NR] of replay_window; footprints[N];
///     slot_first[N], the prefix sum of slot_counts
/// out grads[K][16]: dL/dA (9, times r), dL/do' (3, times r), dL/d ln sigma, dL/d features (3); every slot of
///     every pair is written. With ERRORS pair_error[K]: sum over its rays of weight x ray_error[slots]
__kernel SIM_GROUP void render_bwd(const FrameParams frame,
                                   __global const SensorConstants* sensor,
                                   __global const real* world_ray,
                                   __global const real* ray_u,
                                   __global const uint* first,
                                   __global const uint* payload,
                                   __global const real* records,
                                   __global const real* motions,
                                   __global const Footprint* footprints,
                                   __global const uint* slot_first,
                                   __global const real* out,
                                   __global const real* grad_out,
                                   __global real* grads,
                                   __global const real* ray_error,
                                   __global real* pair_error,
                                   const uint tile_first,
                                   __global const real* replayed,
                                   __global const uint* replayed_to) {
  const uint group = tile_first + get_group_id(0);
  const Tile tile = tile_at(group, sensor, ray_u, first, payload, records, motions);
  const SlotMap map = {group % frame.tiles_x, group / frame.tiles_x, footprints, slot_first};
  struct Blending b;
  uint alive = 0;  // one bit per vector that still has an active ray
  uint end = tile.end;
#if RAY_ORDER
  b.replayed = replayed + (ulong)(tile.begin - first[tile_first]) * SIM_REPLAYED;
  uint all_to = 0;
#endif
  for (int j = 0; j < NR; ++j) {
    const uint slot = tile.base + SIM_VECTOR_SLOT(j, tile.lid);
    load_ray(world_ray, ray_u, frame.slots, slot, &b.ray[j]);
    b.g0[j] = LDV(grad_out + slot);
    b.g1[j] = LDV(grad_out + frame.slots + slot);
    b.g2[j] = LDV(grad_out + 2 * frame.slots + slot);
    b.gd[j] = LDV(grad_out + SIM_O_DISTANCE * frame.slots + slot);
#if ERRORS
    b.error[j] = LDV(ray_error + slot);
#endif
#if RAY_ORDER
    b.to[j] = replayed_to[(group * LS + tile.lid) * NR + j];
    all_to = max(all_to, b.to[j]);
    alive |= (b.to[j] > 0 ? 1u : 0u) << j;
#else
    b.transmittance[j] = (F)R(1.0);
    b.behind[j] = behind_of(out + slot, grad_out + slot, frame.slots);
    alive |= alive_bit(&b.ray[j], j);
#endif
  }
#if RAY_ORDER
  end = tile.begin + all_to;
#endif

  uint i = tile.begin;
  for (; i < end && alive; ++i) {
    fetch_ahead(&tile, i, &map, grads);
    TilePair at;
    load_pair(&tile, i - tile.begin, &at);
    Sums sums;
    SIM_EACH(k, SIM_GRAD) sums.grad[k] = (F)R(0.0);
    sums.error = (F)R(0.0);
    add_pair(&tile, &at, &alive, &b, &sums);
    const ulong slot = gradient_slot(&map, at.particle);
    __global real* target = grads + SIM_GRAD * slot;
#if V == 16
    vstore16(hsum16_each(sums.grad), 0, target);
#else
    SIM_EACH(k, SIM_GRAD) target[k] = HSUM(sums.grad[k]);
#endif
    if (ERRORS) pair_error[slot] = HSUM(sums.error);
  }
  clear_slots(&map, payload, i, tile.end, grads, pair_error);
}

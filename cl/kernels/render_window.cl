// render_window.cl - blending in each ray's own order. Launcher: host/render/frame/render.cpp
// Build: WINDOW entries, 2 or more; PER_RAY = 1 tells the vectors that they were too few for, and makes these exactly;
// REPLAY = 1 to go over it once more for render_bwd.cl. Launcher then: host/render/backward/render_bwd.cpp
#include "math/light.h"

/// What the rays of one vector have met and not blended yet, nearest first: entry i of all that were ever put
/// in came to i % WINDOW.
typedef struct {
  Met entry[WINDOW];
  uint count;  // ever put in
} Window;

/// Puts `met` in; where the window is full, its nearest has been blended before. A list by range is nearly in order:
/// most stay where they come in, at the far end.
FN void put(Window* w, Met* met) {
  uint k = w->count++;
  const uint nearest = k < WINDOW ? 0 : k - (WINDOW - 1);
  for (; k > nearest; --k) {
    const Met* before = &w->entry[(k - 1) % WINDOW];
    const I nearer = met->tau < before->tau;
    if (!ANY(nearer)) break;
    pass_by(nearer, before, &w->entry[k % WINDOW], met);
  }
  copy_met(met, &w->entry[k % WINDOW]);
}

/// Contract of `render`, but for the order: each ray blends the nearest of the last WINDOW responses of its
/// vector, so that those blend in the ray's own order that are not farther from it in the list than that.
/// out inverted[tiles][LS], with PER_RAY: bits of the vectors in which a ray met something nearer than what it
///     had blended already, also after its end. Their outputs are not made. All others have exact order.
/// replay_window, with REPLAY: the same once more, of tiles from tile_first on.
/// in  out, grad_out of render_bwd(); with PER_RAY: inverted
/// out replayed[places][2][TILE_RAYS], places counted from the list of tile_first on: the weight of what each ray
///     has met there, and the gradient of its ln alpha; 0 where it has blended nothing. Not set for vectors that
///     the particle does not touch, nor from replayed_to on
///     replayed_to[tiles][LS][NR]: the place in the tile's list that a vector needs no more
#if !REPLAY
__kernel GROUP void render_window(const FrameParams frame,
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
                            __global uint* inverted,
                            __global real* out) {
  const uint tile = get_group_id(0);
#else
__kernel GROUP void replay_window(const FrameParams frame,
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
                            __global const uint* inverted,
                            __global const real* out,
                            __global const real* grad_out,
                            const uint tile_first,
                            __global real* replayed,
                            __global uint* replayed_to) {
  const uint tile = tile_first + get_group_id(0);
#endif
  const uint lid = get_local_id(0);
  const uint base = tile * TILE_RAYS;
  const uint begin = first[tile];
  const real tile_u = ray_u[base];
  const real t_min = sensor->model.t_min;
  const real t_max = sensor->model.t_max;
  const real t_cut = sensor->transmittance_cut;
  const real log_cut = log(sensor->alpha_cut);

  RayLanes ray[NR];
  Light light[NR];
  Window window[NR];
  uint alive = 0;  // a bit per vector that still looks at the list
  for (int j = 0; j < NR; ++j) {
    const uint slot = base + VECTOR_SLOT(j, lid);
    load_ray(world_ray, ray_u, frame.slots, slot, &ray[j]);
#if REPLAY
    __global real* replayed_j =
        replayed + (ulong)(begin - first[tile_first]) * REPLAYED + VECTOR_SLOT(j, lid);
    start_light(&ray[j], out + slot, grad_out + slot, frame.slots, replayed_j, &light[j]);
#else
    start_light(&ray[j], &light[j]);
#endif
    window[j].count = 0;
    alive |= (ANY(light[j].going) ? 1u : 0u) << j;
  }

  const uint end = first[tile + 1];
#if REPLAY
  uint to[NR];
  for (int j = 0; j < NR; ++j) to[j] = alive >> j & 1u ? end - begin : 0;
#if PER_RAY
  alive &= ~inverted[tile * LS + lid];
#endif
#elif PER_RAY
  uint redo = 0;
#endif
#if LS > 1
#define PLACE (batch + i - begin)  // in the tile's list
  __local REAL_VECTOR(4) staged[STAGED_RECORDS];
  __local uint staged_payload[LS];
  __local int group_alive;
  for (uint batch = begin; batch < end; batch += LS) {
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
#define PLACE (i - begin)
  for (uint i = begin; i < end && alive; ++i) {
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
      for (int j = J_FIRST(packed); j <= j_last; ++j) {
        if (J_OUTSIDE(j, lid, packed) || !(alive >> j & 1u)) continue;
        RayLanes seen = ray[j];
#if ACTOR_MOTION
        if (moves) seen = follow(&ray[j], motion);
#endif
        Response response;
        respond(record, box_mean, &seen, t_min, t_max, &response);
        if (!ANY(response.inside)) continue;
#if REPLAY
        clear_place(PLACE, light[j].replayed);
#endif
        const I inside = AND(response.inside, light[j].going);
        Window* w = &window[j];
        if (w->count >= WINDOW && ANY(inside)) blend(&w->entry[w->count % WINDOW], t_cut, &light[j]);
#if PER_RAY && !REPLAY
        if (ANY(AND(response.inside, response.tau < light[j].last))) {
          redo |= 1u << j;
          alive &= ~(1u << j);
          continue;
        }
#else
        if (!ANY(light[j].going)) {
          alive &= ~(1u << j);
#if REPLAY
          to[j] = PLACE;
#endif
          continue;
        }
#endif
        if (!ANY(inside)) continue;
        Met met;
#if REPLAY
        met.place = (F)(real)(PLACE);
#endif
        const F last = w->count > 0 ? w->entry[(w->count - 1) % WINDOW].tau : (F)R(0.0);
        met.tau = SEL(inside, response.tau, last);
        met.alpha = SEL(inside, VMIN(raw_alpha(record, response.q, log_cut), (F)ALPHA_MAX), (F)R(0.0));
        set_feature(&met, params, frame.stride, packed & SIM_PARTICLE_MASK, actor_of, actors, record, ray[j].d);
        put(w, &met);
      }
    }
  }

  for (int j = 0; j < NR; ++j) {
#if PER_RAY && !REPLAY
    if (redo >> j & 1u) continue;
#endif
    const uint count = window[j].count;
    for (uint i = count < WINDOW ? 0 : count - WINDOW; i < count; ++i) {
      if (!ANY(light[j].going)) break;
      blend(&window[j].entry[i % WINDOW], t_cut, &light[j]);
    }
#if REPLAY
    replayed_to[(tile * LS + lid) * NR + j] = to[j];
#else
    write_light(&light[j], sensor, frame.slots, out + base + VECTOR_SLOT(j, lid));
#endif
  }
#if PER_RAY && !REPLAY
  inverted[tile * LS + lid] = redo;
#endif
}

#if PER_RAY
// The nearest responses of a vector that a round keeps. GPUs have them in scratch memory, for every work-item
// that may run.
#if LS == 1
#define NEAREST 128
#else
#define NEAREST 16
#endif

/// One row of slots of a tile, and the list that it goes over.
typedef struct {
  __global const uint* list;  // [count]
  uint count;
  __global const real* records;
  __global const real* motions;
  __global const real* params;
  __global const uint* actor_of;
  __global const ActorConstants* actors;
  uint stride;
  real u;  // of the tile
  uint lid;
  int j;
} TileRow;

/// What a round has found of V rays: the nearest responses behind those of the last round.
typedef struct {
  Met entry[NEAREST];
  F place[NEAREST];  // in the tile's list
  uint count;
  F last_tau, last_place;  // of the last round
  F left_over;             // the first place that the next round must look at
} Round;

/// Puts in what the rays `ahead` meet, `place` of the list. Of a full round the farthest drops out.
FN void put_ahead(Round* round, I ahead, F place, Met* met) {
  uint k = round->count;
  const uint last = k - 1;
  met->tau = SEL(ahead, met->tau, k > 0 ? round->entry[last].tau : round->last_tau);
  met->alpha = SEL(ahead, met->alpha, (F)R(0.0));
  place = SEL(ahead, place, k > 0 ? round->place[last] : round->last_place);
  if (k < NEAREST) {
    ++round->count;
  } else {
    Met dropped;
    const I nearer = met->tau < round->entry[last].tau;
    const F dropped_place = SEL(nearer, round->place[last], place);
    place = SEL(nearer, place, round->place[last]);
    pass_by(nearer, &round->entry[last], &dropped, met);
    round->left_over = SEL(dropped.alpha > R(0.0), VMIN(round->left_over, dropped_place), round->left_over);
    k = last;
  }
  for (; k > 0; --k) {
    const I nearer = met->tau < round->entry[k - 1].tau;
    if (!ANY(nearer)) break;
    round->place[k] = SEL(nearer, round->place[k - 1], place);
    place = SEL(nearer, place, round->place[k - 1]);
    pass_by(nearer, &round->entry[k - 1], &round->entry[k], met);
  }
  round->place[k] = place;
  copy_met(met, &round->entry[k]);
}

/// Fills a round from place `begin` of the list on.
FN void gather(const TileRow* tile,
               __global const SensorConstants* sensor,
               const RayLanes* ray,
               I going,
               real log_cut,
               uint begin,
               Round* round) {
  round->count = 0;
  round->left_over = (F)(real)tile->count;
  for (uint i = begin; i < tile->count; ++i) {
    const uint packed = tile->list[i];
    const uint particle = packed & SIM_PARTICLE_MASK;
    if (tile->j < J_FIRST(packed) || tile->j > J_LAST(packed) || J_OUTSIDE(tile->j, tile->lid, packed)) continue;
    real record[SIM_RECORD];
    load_record(tile->records + (ulong)particle * SIM_RECORD, record);
    RayLanes seen = *ray;
#if ACTOR_MOTION
    real motion[SIM_MOTION];
    if (take_motion(record, tile->motions, particle, motion)) seen = follow(ray, motion);
#endif
    Response response;
    respond(record, nearest_box_mean(record, tile->u), &seen, sensor->model.t_min, sensor->model.t_max, &response);
    Met met;
    met.tau = response.tau;
    const F place = (F)(real)i;
#if REPLAY
    met.place = place;
#endif
    const I behind =
        OR(met.tau > round->last_tau, AND(met.tau == round->last_tau, place > round->last_place));
    const I ahead = AND(AND(response.inside, going), behind);
    if (!ANY(ahead)) continue;
    if (round->count == NEAREST && !ANY(AND(ahead, met.tau < round->entry[NEAREST - 1].tau))) {
      round->left_over = SEL(ahead, VMIN(round->left_over, place), round->left_over);
      continue;
    }
    met.alpha = VMIN(raw_alpha(record, SEL(ahead, response.q, (F)R(0.0)), log_cut), (F)ALPHA_MAX);
    set_feature(&met, tile->params, tile->stride, particle, tile->actor_of, tile->actors, record, ray->d);
    put_ahead(round, ahead, place, &met);
  }
}

/// Contract of `render`, but for the order, and for the vectors of inverted[tiles][LS] alone: front to back by the
/// place of maximum response along each ray, places in the list deciding between equal ones. Exact for lists of up
/// to 2^24: a vector goes over its tile's list in rounds, each of which blends the NEAREST nearest responses behind
/// those of the last; the next one begins at the first response that was left over.
/// replay_per_ray, with REPLAY: the same once more, as replay_window.
#if !REPLAY
__kernel GROUP void render_per_ray(const FrameParams frame,
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
                             __global const uint* inverted,
                             __global real* out) {
  const uint tile = get_group_id(0);
#else
__kernel GROUP void replay_per_ray(const FrameParams frame,
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
                             __global const uint* inverted,
                             __global const real* out,
                             __global const real* grad_out,
                             const uint tile_first,
                             __global real* replayed) {
  const uint tile = tile_first + get_group_id(0);
#endif
  const uint lid = get_local_id(0);
  const uint base = tile * TILE_RAYS;
  const uint redo = inverted[tile * LS + lid];
  const uint count = first[tile + 1] - first[tile];
  const real log_cut = log(sensor->alpha_cut);
  for (int j = 0; j < NR; ++j) {
    if (!(redo >> j & 1u)) continue;
    const TileRow row = {
        payload + first[tile], count, records, motions, params, actor_of, actors, frame.stride, ray_u[base], lid, j};
    RayLanes ray;
    Light light;
    const uint slot = base + VECTOR_SLOT(j, lid);
    load_ray(world_ray, ray_u, frame.slots, slot, &ray);
#if REPLAY
    __global real* replayed_j =
        replayed + (ulong)(first[tile] - first[tile_first]) * REPLAYED + VECTOR_SLOT(j, lid);
    start_light(&ray, out + slot, grad_out + slot, frame.slots, replayed_j, &light);
    for (uint place = 0; place < count; ++place) clear_place(place, replayed_j);
#else
    start_light(&ray, &light);
#endif
    Round round;
    round.last_tau = round.last_place = (F)R(-1.0);
    uint begin = 0;
    while (begin < count && ANY(light.going)) {
      gather(&row, sensor, &ray, light.going, log_cut, begin, &round);
      if (round.count == 0) break;
      for (uint k = 0; k < round.count && ANY(light.going); ++k) {
        blend(&round.entry[k], sensor->transmittance_cut, &light);
      }
      round.last_tau = round.entry[round.count - 1].tau;
      round.last_place = round.place[round.count - 1];
      real places[V];
      STV(places, SEL(light.going, round.left_over, (F)(real)count));
      begin = count;
      for (int lane = 0; lane < V; ++lane) begin = min(begin, (uint)places[lane]);
    }
#if !REPLAY
    write_light(&light, sensor, frame.slots, out + slot);
#endif
  }
}
#endif

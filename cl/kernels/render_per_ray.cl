// render_per_ray.cl - blending in each ray's own order. Launcher: host/render/frame/render.cpp
#include "math/ray_drop.h"
#include "math/ray_feature.h"
#include "math/response.h"

// The nearest responses of a ray that are kept at a time.
#define WINDOW 16
// Farther than any place on a ray: an empty entry.
#define NOWHERE R(1e30)

/// The nearest responses of V rays that a round has met, nearest first.
typedef struct {
  F tau[WINDOW];    // m
  F alpha[WINDOW];
  F place[WINDOW];  // in the tile's list
} Window;

/// Puts (tau, alpha, place) in; lanes with NOWHERE put nothing. The farthest entry drops out.
FN void insert(Window* w, F tau, F alpha, F place) {
  for (int k = WINDOW - 1; k > 0; --k) {
    const I behind = tau < w->tau[k - 1];  // this entry makes room
    const I here = tau < w->tau[k];
    w->tau[k] = SEL(behind, w->tau[k - 1], SEL(here, tau, w->tau[k]));
    w->alpha[k] = SEL(behind, w->alpha[k - 1], SEL(here, alpha, w->alpha[k]));
    w->place[k] = SEL(behind, w->place[k - 1], SEL(here, place, w->place[k]));
    if (!ANY(behind)) return;
  }
  const I first = tau < w->tau[0];
  w->tau[0] = SEL(first, tau, w->tau[0]);
  w->alpha[0] = SEL(first, alpha, w->alpha[0]);
  w->place[0] = SEL(first, place, w->place[0]);
}

/// One row of slots of a tile, and the list that it goes over.
typedef struct {
  __global const uint* list;  // [count]
  uint count;
  __global const real* records;
  __global const real* motions;
  __global const uint* keys;
  real u;  // of the tile
  uint lid;
  int j;
} TileRow;

/// What V rays have blended so far.
typedef struct {
  F transmittance, distance, median;
  F sum[3];
  I going;
} Light;

/// Fills the window with the nearest responses behind (last_tau, last_place) from place `begin` of the list on.
/// Returns the first place that the next round must look at.
FN F gather(const TileRow* tile,
            __global const SensorConstants* sensor,
            const RayLanes* ray,
            I going,
            real log_cut,
            F last_tau,
            F last_place,
            uint begin,
            Window* w) {
  for (int k = 0; k < WINDOW; ++k) {
    w->tau[k] = (F)NOWHERE;
    w->alpha[k] = w->place[k] = (F)R(0.0);
  }
  F left_over = (F)(real)tile->count;  // the first place that the next round must look at
  for (uint i = begin; i < tile->count; ++i) {
    const uint packed = tile->list[i];
    const uint particle = packed & SIM_PARTICLE_MASK;
    if (tile->j < J_FIRST(packed) || tile->j > J_LAST(packed) || J_OUTSIDE(tile->j, tile->lid, packed)) continue;
    if (!ANY(AND(going, w->tau[WINDOW - 1] > (real)as_float(tile->keys[particle])))) {
      left_over = VMIN(left_over, (F)(real)i);
      break;
    }
    const __global real* source = tile->records + (ulong)particle * SIM_RECORD;
    real record[SIM_RECORD];
    for (int k = 0; k < SIM_RECORD; ++k) record[k] = source[k];
    const RayLanes* seen = ray;
#if ACTOR_MOTION
    real motion[SIM_MOTION];
    RayLanes followed;
    if (take_motion(record, tile->motions, particle, motion)) {
      followed = follow(ray, motion);
      seen = &followed;
    }
#endif
    Response response;
    respond(record, nearest_box_mean(record, tile->u), seen, sensor->model.t_min, sensor->model.t_max, &response);
    const F place = (F)(real)i;
    const I ahead = OR(response.tau > last_tau, AND(response.tau == last_tau, place > last_place));
    const I candidate = AND(response.inside, ahead);
    const I fits = AND(candidate, response.tau < w->tau[WINDOW - 1]);
    left_over = SEL(candidate, VMIN(left_over, SEL(fits, left_over, place)), left_over);
    if (!ANY(fits)) continue;
    const I drops = AND(fits, w->tau[WINDOW - 1] < NOWHERE);
    left_over = SEL(drops, VMIN(left_over, w->place[WINDOW - 1]), left_over);
    const F alpha = VMIN(raw_alpha(record, SEL(fits, response.q, (F)R(0.0)), log_cut), (F)ALPHA_MAX);
    insert(w, SEL(fits, response.tau, (F)NOWHERE), alpha, place);
  }
  return left_over;
}

/// Blends what the window holds, nearest first; params, actor_of and actors as ray_feature(), for rays along d.
FN void blend(const FrameParams* frame,
              __global const SensorConstants* sensor,
              __global const real* params,
              __global const uint* actor_of,
              __global const ActorConstants* actors,
              const TileRow* tile,
              const Window* w,
              const F* d,
              Light* light) {
  for (int k = 0; k < WINDOW; ++k) {
    const I met = AND(light->going, w->tau[k] < NOWHERE);
    if (!ANY(met)) break;
    const F tau = SEL(met, w->tau[k], (F)R(0.0));
    const F weight = SEL(met, w->alpha[k], (F)R(0.0)) * light->transmittance;
    // Lanes have met different particles here.
    real which[V], is_met[V], features[3 * V];
    STV(which, w->place[k]);
    STV(is_met, SEL(met, (F)R(1.0), (F)R(0.0)));
    for (int lane = 0; lane < V; ++lane) {
      for (int c = 0; c < 3; ++c) features[c * V + lane] = R(0.0);
      if (!(is_met[lane] > R(0.5))) continue;
      const uint particle = tile->list[(uint)which[lane]] & SIM_PARTICLE_MASK;
#if RAY_SH
      F feature[3];
      real lanes[V];
      ray_feature(params, frame->stride, particle, actor_of, actors, d, feature);
      for (int c = 0; c < 3; ++c) {
        STV(lanes, feature[c]);
        features[c * V + lane] = lanes[lane];
      }
#else
      const __global real* record = tile->records + (ulong)particle * SIM_RECORD;
      for (int c = 0; c < 3; ++c) features[c * V + lane] = record[SIM_R_FEATURE + c];
#endif
    }
    for (int c = 0; c < 3; ++c) light->sum[c] = fma(weight, LDV(features + c * V), light->sum[c]);
    light->distance = fma(weight, tau, light->distance);
    const F left = light->transmittance - weight;
    light->median = SEL(AND(met, AND(light->transmittance > R(0.5), left <= R(0.5))), tau, light->median);
    light->transmittance = left;
    light->going = AND(light->going, NOT(AND(met, left < sensor->transmittance_cut)));
  }
}

/// Contract of `render`, but for the order: front to back by the place of maximum response along each ray,
/// places in the list deciding between equal ones. keys[N]: of project with PER_RAY, rising along payload.
/// Exact for lists of up to 2^24: a ray goes over its tile's list in rounds, each of which blends the WINDOW
/// nearest responses behind those of the last; a round ends where the rest of the list is known to lie
/// farther, the next one begins at the first response that was left over.
__kernel void render(const FrameParams frame,
                     __global const SensorConstants* sensor,
                     __global const real* world_ray,
                     __global const real* ray_u,
                     __global const uint* first,
                     __global const uint* payload,
                     __global const real* records,
                     __global const real* motions,
                     __global const uint* keys,
                     __global const real* params,
                     __global const uint* actor_of,
                     __global const ActorConstants* actors,
                     __global real* out) {
  const uint tile = get_group_id(0);
  const uint lid = get_local_id(0);
  const uint base = tile * TILE_RAYS;
  const real tile_u = ray_u[base];
  const real log_cut = log(sensor->alpha_cut);
  __global const uint* list = payload + first[tile];
  const uint count = first[tile + 1] - first[tile];

  for (int j = 0; j < NR; ++j) {
    RayLanes ray;
    load_ray(world_ray, ray_u, frame.slots, base + VECTOR_SLOT(j, lid), &ray);
    const F d[3] = {ray.d[0], ray.d[1], ray.d[2]};
    const TileRow tile_row = {list, count, records, motions, keys, tile_u, lid, j};
    Light light;
    light.going = is_ray(d[0], d[1], d[2]);
    light.transmittance = (F)R(1.0);
    light.distance = light.median = (F)R(0.0);
    for (int c = 0; c < 3; ++c) light.sum[c] = (F)R(0.0);
    F last_tau = (F)R(-1.0), last_place = (F)R(-1.0);
    uint begin = 0;
    while (begin < count && ANY(light.going)) {
      Window w;
      const F left_over = gather(&tile_row, sensor, &ray, light.going, log_cut, last_tau, last_place, begin, &w);
      blend(&frame, sensor, params, actor_of, actors, &tile_row, &w, d, &light);
      last_tau = w.tau[WINDOW - 1];
      last_place = w.place[WINDOW - 1];

      // A ray that is done meets nothing any more.
      for (int k = 0; k < 3; ++k) ray.d[k] = SEL(light.going, ray.d[k], (F)R(0.0));
      real places[V];
      STV(places, SEL(light.going, left_over, (F)(real)count));
      begin = count;
      for (int lane = 0; lane < V; ++lane) begin = min(begin, (uint)places[lane]);
    }

    __global real* slot = out + base + VECTOR_SLOT(j, lid);
    for (int c = 0; c < 3; ++c) {
      light.sum[c] = fma(light.transmittance, (F)sensor->background[c], light.sum[c]);
      STV(slot + (ulong)c * frame.slots, light.sum[c]);
    }
    STV(slot + SIM_O_TRANSMITTANCE * frame.slots, light.transmittance);
    STV(slot + SIM_O_DISTANCE * frame.slots, light.distance);
#if MEDIAN
    STV(slot + SIM_O_MEDIAN * frame.slots, light.median);
#endif
#if DROP
    STV(slot + SIM_O_DROP * frame.slots,
        drop_of(&sensor->drop, light.sum[0], light.sum[1], light.sum[2], light.transmittance, light.distance));
#endif
  }
}

// replay_window.cl - replays render_window for render_bwd. Launcher: host/device/render/backward/render_bwd.cpp
// Build: as render_window.cl
#define SIM_REPLAY 1
#include "math/light_bwd.h"
#include "math/tile_walk.h"
#include "math/window.h"

struct Blending {
  RayLanes ray[NR];
  Light light[NR];
  Window window[NR];
  Features features;
  uint to[NR];  // end of the list entries that each vector processes
};

FN void blend_pair(const Tile* tile, const TilePair* at, uint* alive, struct Blending* b) {
  uint vectors = vectors_of(at->packed, tile->lid) & *alive;
  SIM_EACH_VECTOR_OF(j, vectors) {
    RayLanes own;
    Response response;
    meet(tile, at, seen_by(at, &b->ray[j], &own), &response);
    if (!ANY(response.inside)) continue;
    Light* light = &b->light[j];
    clear_place(at->place, light->replayed);
    const I inside = AND(response.inside, light->going);
    blend_nearest(&b->window[j], inside, tile->t_cut, light);
    if (!ANY(light->going)) {
      *alive &= ~(1u << j);
      b->to[j] = at->place;
      continue;
    }
    if (!ANY(inside)) continue;
    put_pair(&b->window[j], tile, at, &response, inside, &b->features, b->ray[j].d);
  }
}

/// Replays render_window for tiles from tile_first on.
/// in  as render_window; out, grad_out of render_bwd(); with PER_RAY inverted, whose vectors replay_per_ray
///     handles
/// out replayed[places][2][SIM_WALK_RAYS], with list entries counted from the list of tile_first: weight of
///     each ray's response and gradient of its ln alpha; 0 where the ray blended nothing. Not set for vectors
///     that the particle does not touch, nor from replayed_to on
///     replayed_to[tiles][LS][NR]: end of the list entries that a vector needs
__kernel SIM_GROUP void replay_window(const FrameParams frame,
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
  const uint group = tile_first + get_group_id(0);
  const Tile tile = tile_at(group, sensor, ray_u, first, payload, records, motions);
  __global real* replayed_here = replayed + (ulong)(tile.begin - first[tile_first]) * SIM_REPLAYED;
  struct Blending b;
  b.features = features_of(params, frame.stride, actor_of, actors);
  uint alive = 0;  // one bit per vector that still processes the list
  for (int j = 0; j < NR; ++j) {
    const uint place = SIM_VECTOR_SLOT(j, tile.lid), slot = tile.base + place;
    load_ray(world_ray, ray_u, frame.slots, slot, &b.ray[j]);
    start_light(&b.ray[j], out + slot, grad_out + slot, frame.slots, replayed_here + place, &b.light[j]);
    b.window[j].count = 0;
    alive |= alive_bit(&b.ray[j], j);
    b.to[j] = alive >> j & 1u ? tile.end - tile.begin : 0;
  }
#if PER_RAY
  alive &= ~inverted[group * LS + tile.lid];
#endif

  SIM_WALK(&tile, &alive, &b);

  for (int j = 0; j < NR; ++j) {
    blend_rest(&b.window[j], tile.t_cut, &b.light[j]);
    replayed_to[(group * LS + tile.lid) * NR + j] = b.to[j];
  }
}

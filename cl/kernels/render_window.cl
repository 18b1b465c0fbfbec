// render_window.cl - blending in the order of each ray within a window. Launcher: host/device/render/frame/render.cpp
// Build: WINDOW entries, 2 or more; PER_RAY = 1 marks the vectors whose window was too small, which
// render_per_ray then renders.
#include "math/light.h"
#include "math/tile_walk.h"
#include "math/window.h"

struct Blending {
  RayLanes ray[NR];
  Light light[NR];
  Window window[NR];
  Features features;
  uint inverted;  // vectors, one bit each
};

FN void blend_pair(const Tile* tile, const TilePair* at, uint* alive, struct Blending* b) {
  uint vectors = vectors_of(at->packed, tile->lid) & *alive;
  SIM_EACH_VECTOR_OF(j, vectors) {
    RayLanes own;
    Response response;
    meet(tile, at, seen_by(at, &b->ray[j], &own), &response);
    if (!ANY(response.inside)) continue;
    Light* light = &b->light[j];
    const I inside = AND(response.inside, light->going);
    blend_nearest(&b->window[j], inside, tile->t_cut, light);
#if PER_RAY
    if (ANY(AND(response.inside, response.tau < light->last))) {
      b->inverted |= 1u << j;
      *alive &= ~(1u << j);
      continue;
    }
#else
    if (!ANY(light->going)) {
      *alive &= ~(1u << j);
      continue;
    }
#endif
    if (!ANY(inside)) continue;
    put_pair(&b->window[j], tile, at, &response, inside, &b->features, b->ray[j].d);
  }
}

/// Contract as `render`, except for the order: each ray blends the nearest of the last WINDOW responses of its
/// vector, which is the ray's own order if no response is farther than WINDOW entries from its place in the
/// list.
/// out inverted[tiles][LS], with PER_RAY: bits of the vectors in which a ray hit a response nearer than one it
///     had already blended, also after its termination. Their outputs are not written; all others have exact
///     order.
__kernel SIM_GROUP void render_window(const FrameParams frame,
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
  const uint group = get_group_id(0);
  const Tile tile = tile_at(group, sensor, ray_u, first, payload, records, motions);
  struct Blending b;
  b.features = features_of(params, frame.stride, actor_of, actors);
  b.inverted = 0;
  uint alive = 0;  // one bit per vector that still processes the list
  for (int j = 0; j < NR; ++j) {
    load_ray(world_ray, ray_u, frame.slots, tile.base + SIM_VECTOR_SLOT(j, tile.lid), &b.ray[j]);
    start_light(&b.ray[j], &b.light[j]);
    b.window[j].count = 0;
    alive |= alive_bit(&b.ray[j], j);
  }

  SIM_WALK(&tile, &alive, &b);

  for (int j = 0; j < NR; ++j) {
    if (b.inverted >> j & 1u) continue;
    blend_rest(&b.window[j], tile.t_cut, &b.light[j]);
    write_light(&b.light[j], sensor, frame.slots, out + tile.base + SIM_VECTOR_SLOT(j, tile.lid));
  }
#if PER_RAY
  inverted[group * LS + tile.lid] = b.inverted;
#endif
}

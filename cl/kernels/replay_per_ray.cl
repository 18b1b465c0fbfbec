// replay_per_ray.cl - replays render_per_ray for render_bwd. Launcher: host/device/render/backward/render_bwd.cpp
#define SIM_REPLAY 1
#include "math/light_bwd.h"
#include "math/rounds.h"

/// Replays tiles from tile_first on; arguments as in replay_window.
__kernel SIM_GROUP void replay_per_ray(const FrameParams frame,
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
  const uint group = tile_first + get_group_id(0);
  const Tile tile = tile_at(group, sensor, ray_u, first, payload, records, motions);
  const Features features = features_of(params, frame.stride, actor_of, actors);
  const uint redo = inverted[group * LS + tile.lid];
  for (int j = 0; j < NR; ++j) {
    if (!(redo >> j & 1u)) continue;
    const uint place = SIM_VECTOR_SLOT(j, tile.lid), slot = tile.base + place;
    __global real* replayed_j = replayed + (ulong)(tile.begin - first[tile_first]) * SIM_REPLAYED + place;
    RayLanes ray;
    Light light;
    load_ray(world_ray, ray_u, frame.slots, slot, &ray);
    start_light(&ray, out + slot, grad_out + slot, frame.slots, replayed_j, &light);
    for (uint at = 0; at < tile.end - tile.begin; ++at) clear_place(at, replayed_j);
    blend_in_rounds(&tile, &features, &ray, j, &light);
  }
}

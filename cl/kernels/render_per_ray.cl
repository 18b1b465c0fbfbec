// render_per_ray.cl - blending in the exact order of each ray. Launcher: host/device/render/frame/render.cpp
#include "math/light.h"
#include "math/rounds.h"

/// Contract as `render`, except for the order (blend_in_rounds()), for the vectors marked in
/// inverted[tiles][LS] that render_window left.
__kernel SIM_GROUP void render_per_ray(const FrameParams frame,
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
  const uint group = get_group_id(0);
  const Tile tile = tile_at(group, sensor, ray_u, first, payload, records, motions);
  const Features features = features_of(params, frame.stride, actor_of, actors);
  const uint redo = inverted[group * LS + tile.lid];
  for (int j = 0; j < NR; ++j) {
    if (!(redo >> j & 1u)) continue;
    const uint slot = tile.base + SIM_VECTOR_SLOT(j, tile.lid);
    RayLanes ray;
    Light light;
    load_ray(world_ray, ray_u, frame.slots, slot, &ray);
    start_light(&ray, &light);
    blend_in_rounds(&tile, &features, &ray, j, &light);
    write_light(&light, sensor, frame.slots, out + slot);
  }
}

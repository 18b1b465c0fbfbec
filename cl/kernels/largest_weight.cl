// largest_weight.cl - the largest blending weight of each particle over all rays. Launcher: host/device/render/train/largest_weight.cpp
#include "math/tile_walk.h"

struct Blending {
  RayLanes ray[NR];
  F transmittance[NR];
  __global uint* largest;
};

FN void blend_pair(const Tile* tile, const TilePair* at, uint* alive, struct Blending* b) {
  F most = (F)R(0.0);
  uint vectors = vectors_of(at->packed, tile->lid) & *alive;
  SIM_EACH_VECTOR_OF(j, vectors) {
    RayLanes own;
    Response response;
    meet(tile, at, seen_by(at, &b->ray[j], &own), &response);
    if (!ANY(response.inside)) continue;
    const F weight = alpha_of(response.inside, at->record, response.q, tile->log_cut) * b->transmittance[j];
    most = VMAX(most, weight);
    b->transmittance[j] -= weight;
    terminate_ray(AND(b->transmittance[j] < tile->t_cut, response.inside), j, &b->ray[j], alive);
  }
  const uint bits = as_uint((float)HMAX(most));
  // Not compared first: other work-items write the value at the same time.
  if (bits > 0) atomic_max(b->largest + at->particle, bits);
}

/// Blends as render does and keeps each particle's largest weight in any ray. Bits of floats >= 0 increase with
/// their value, so the maximum is an integer maximum, which does not depend on order.
/// in  as render
/// out largest[N]: bits of a float each, at least the previous value
__kernel SIM_GROUP void largest_weight(const FrameParams frame,
                                       __global const SensorConstants* sensor,
                                       __global const real* world_ray,
                                       __global const real* ray_u,
                                       __global const uint* first,
                                       __global const uint* payload,
                                       __global const real* records,
                                       __global const real* motions,
                                       __global uint* largest) {
  const Tile tile = tile_at(get_group_id(0), sensor, ray_u, first, payload, records, motions);
  struct Blending b;
  b.largest = largest;
  uint alive = 0;  // one bit per vector that still has an active ray
  SIM_EACH_VECTOR
  for (int j = 0; j < NR; ++j) {
    load_ray(world_ray, ray_u, frame.slots, tile.base + SIM_VECTOR_SLOT(j, tile.lid), &b.ray[j]);
    b.transmittance[j] = (F)R(1.0);
    alive |= alive_bit(&b.ray[j], j);
  }
  SIM_WALK(&tile, &alive, &b);
}

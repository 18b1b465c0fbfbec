// tile_walk.h - traverses a tile's list of particles, nearest first, for all kernels that blend. These define
// `struct Blending`, the state of a work-item's rays, and blend_pair().
#ifndef SIMULI_CL_MATH_TILE_WALK_H
#define SIMULI_CL_MATH_TILE_WALK_H
#include "math/tile.h"

struct Blending;
/// Processes a pair for each active vector in vectors_of() its payload.
FN void blend_pair(const Tile* tile, const TilePair* at, uint* alive, struct Blending* blending);

#if LS > 1
// Records of a batch: 256 would limit AMD's compute units to a third of their waves.
#define SIM_STAGED (LS < 128 ? LS : 128)

/// Records of a batch of the list, each loaded by one work-item for all.
typedef struct {
  Quarter quarters[SIM_STAGED * SIM_QUARTERS];
  uint payload[SIM_STAGED];
  int alive;
} Staged;

/// Traverses the list while any work-item of the group has active rays. All work-items call it.
FN void walk(const Tile* tile, __local Staged* staged, uint* alive, struct Blending* blending) {
  const uint lid = tile->lid;
  for (uint batch = tile->begin; batch < tile->end; batch += SIM_STAGED) {
    barrier(CLK_LOCAL_MEM_FENCE);
    if (lid == 0) staged->alive = 0;
    if (lid < SIM_STAGED && batch + lid < tile->end) {
      const uint packed = tile->payload[batch + lid];
      staged->payload[lid] = packed;
      stage_record(tile->records + (ulong)(packed & SIM_PARTICLE_MASK) * SIM_RECORD, staged->quarters, lid);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    if (*alive) staged->alive = 1;
    barrier(CLK_LOCAL_MEM_FENCE);
    if (!staged->alive) break;
    const uint count = min((uint)SIM_STAGED, tile->end - batch);
    for (uint i = 0; i < count; ++i) {
      TilePair at;
      staged_record(staged->quarters, i, at.record);
      complete(tile, batch + i - tile->begin, staged->payload[i], 0, &at);
      blend_pair(tile, &at, alive, blending);
    }
  }
}
// A statement of a kernel's outermost scope, the only place where local memory may be declared.
#define SIM_WALK(tile, alive, blending) \
  __local Staged staged;                \
  walk(tile, &staged, alive, blending)
#else
/// Traverses the list while any vector is active; records of particles that touch no active vector are not
/// read.
FN void walk(const Tile* tile, uint* alive, struct Blending* blending) {
  const uint count = tile->end - tile->begin;
  __global const uint* list = tile->payload + tile->begin;
  for (uint place = 0; place < count && *alive; ++place) {
    if (!(*alive & vectors_of(list[place], tile->lid))) continue;
    if (place + SIM_AHEAD < count)
      SIM_PREFETCH(tile->records + (ulong)(list[place + SIM_AHEAD] & SIM_PARTICLE_MASK) * SIM_RECORD);
    TilePair at;
    load_pair(tile, place, &at);
    blend_pair(tile, &at, alive, blending);
  }
}
#define SIM_WALK(tile, alive, blending) walk(tile, alive, blending)
#endif

#endif

// slot_counts.cl - number of gradient slots of each particle. Launcher: host/device/render/backward/render_bwd.cpp
#include "math/lanes.h"
#include "shared/layout.h"

/// Counts one slot per tile-Gaussian pair.
/// out slot_first[n]: number of slots; its prefix sum gives the first slot. Ordered by particle index, not in
///     frame order: neighbours in memory have neighbouring slots, so that a tile's writes lie together and
///     project_bwd reads slots consecutively.
__kernel void slot_counts(const uint n,
                          __global const uint* keys,
                          __global const Footprint* footprints,
                          __global uint* slot_first) {
  const uint i = get_global_id(0);
  if (i < n) slot_first[i] = keys[i] != 0xffffffffu ? SIM_TILES(footprints[i]) : 0;
}

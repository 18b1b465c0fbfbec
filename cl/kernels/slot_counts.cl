// slot_counts.cl - how many gradient slots each particle has. Launcher: host/device/render/backward/render_bwd.cpp
#include "math/lanes.h"
#include "shared/layout.h"

/// out slot_first[n]: how many slots a particle has, one per tile pair; its prefix sum tells where they begin.
///     By index, not in the order of the frame: neighbours in memory have neighbouring slots, so that what a tile
///     writes lies together and project_bwd reads one slot after the other.
__kernel void slot_counts(const uint n,
                          __global const uint* keys,
                          __global const Footprint* footprints,
                          __global uint* slot_first) {
  const uint i = get_global_id(0);
  if (i < n) slot_first[i] = keys[i] != 0xffffffffu ? SIM_TILES(footprints[i]) : 0;
}

// bin.cl - visible particles -> tile pairs -> tile ranges. Launcher: host/device/render/frame/bin.cpp
// Every work-item owns `chunk` consecutive elements: few work-items with long loops suit CPUs, many with
// short ones, in groups of LS, GPUs. All orders are fixed by the input, none by scheduling.
#include "math/lanes.h"
#include "shared/cluster.h"
#include "shared/layout.h"

/// Where the elements of i's cluster end, of those before `last`.
FN uint cluster_end(uint i, uint last) { return min((i / SIM_CLUSTER + 1) * SIM_CLUSTER, last); }

/// What is to be added to elements of i's cluster to know where their particles are.
FN uint cluster_shift(uint paged, __global const uint* cluster_at, uint i) {
  const uint cluster = i / SIM_CLUSTER;
  return paged ? (cluster_at[cluster] - cluster) * SIM_CLUSTER : 0;
}

/// in  keys[n]; live[clusters]: 0 where all keys of a cluster are those of culled particles
///     footprints[n]; with `paged` cluster_at[clusters] as project.cl takes it: keys and footprints lie by particle
/// out counts[2][work-items]: visible particles of each chunk, and their tile pairs, 0xffffffff if these don't fit
///     32 bits: both sums are known before anything is sorted.
__kernel SIM_GROUP void visible_count(__global const uint* keys,
                                      __global const uint* live,
                                      __global const uint* cluster_at,
                                      __global const Footprint* footprints,
                                      const uint paged,
                                      const uint n,
                                      const uint chunk,
                                      __global uint* counts) {
  const uint first = min((uint)get_global_id(0) * chunk, n);
  const uint last = min(first + chunk, n);
  uint count = 0;
  ulong pairs = 0;
  for (uint i = first; i < last;) {
    const uint end = cluster_end(i, last);
    const uint shift = cluster_shift(paged, cluster_at, i);
    if (live[i / SIM_CLUSTER] == 0) i = end;
    for (; i < end; ++i) {
      if (keys[i + shift] == 0xffffffffu) continue;
      ++count;
      pairs += SIM_TILES(footprints[i + shift]);
    }
  }
  counts[get_global_id(0)] = count;
  counts[get_global_size(0) + get_global_id(0)] = (uint)min(pairs, (ulong)0xffffffffu);
}

/// in  offsets[work-items]: exclusive prefix sum of counts
/// out visible_keys, visible[M]: range keys of the visible particles and where they are, in the order of the frame
__kernel SIM_GROUP void visible_write(__global const uint* keys,
                                      __global const uint* live,
                                      __global const uint* cluster_at,
                                      const uint paged,
                                      const uint n,
                                      const uint chunk,
                                      __global const uint* offsets,
                                      __global uint* visible_keys,
                                      __global uint* visible) {
  const uint first = min((uint)get_global_id(0) * chunk, n);
  const uint last = min(first + chunk, n);
  uint place = offsets[get_global_id(0)];
  for (uint i = first; i < last;) {
    const uint end = cluster_end(i, last);
    const uint shift = cluster_shift(paged, cluster_at, i);
    if (live[i / SIM_CLUSTER] == 0) i = end;
    for (; i < end; ++i) {
      if (keys[i + shift] == 0xffffffffu) continue;
      visible_keys[place] = keys[i + shift];
      visible[place] = i + shift;
      ++place;
    }
  }
}

/// in  order[M]: visible particles by range
/// out counts[work-items]: tile pairs of each chunk; the sum of all fits 32 bits
__kernel SIM_GROUP void pair_count(__global const uint* order,
                                       const uint m,
                                       const uint chunk,
                                       __global const Footprint* footprints,
                                       __global uint* counts) {
  const uint first = min((uint)get_global_id(0) * chunk, m);
  const uint last = min(first + chunk, m);
  uint count = 0;
  for (uint i = first; i < last; ++i) {
    if (i + SIM_AHEAD < last) SIM_PREFETCH(footprints + order[i + SIM_AHEAD]);
    count += SIM_TILES(footprints[order[i]]);
  }
  counts[get_global_id(0)] = count;
}

/// Writes the pairs of each particle, nearest particle first.
/// in  tile_rows[tiles_y + 1]: first sensor row of each tile row
/// out tile[K]; payload[K]: particle | first slot row << 24 | last slot row << 28, of blocks those in two corners
__kernel SIM_GROUP void pair_emit(const FrameParams frame,
                                      __global const uint* order,
                                      const uint m,
                                      const uint chunk,
                                      __global const Footprint* footprints,
                                      __global const uint* tile_rows,
                                      __global const uint* offsets,
                                      __global uint* tile,
                                      __global uint* payload) {
  const uint first = min((uint)get_global_id(0) * chunk, m);
  const uint last = min(first + chunk, m);
  uint place = offsets[get_global_id(0)];
  for (uint i = first; i < last; ++i) {
    if (i + SIM_AHEAD < last) SIM_PREFETCH(footprints + order[i + SIM_AHEAD]);
    const uint particle = order[i];
    const Footprint f = footprints[particle];
    const uint row_first = SIM_LOW(f.rows), row_last = SIM_HIGH(f.rows);
    const uint ty0 = SIM_LOW(f.tile_rows), ty1 = ty0 + SIM_HIGH(f.tile_rows);
    for (uint ty = ty0; ty < ty1; ++ty) {
      const uint top = tile_rows[ty];
      const uint row0 = max(row_first, top) - top;
      const uint row1 = min(row_last + 1, tile_rows[ty + 1]) - 1 - top;
      const int blocks = frame.row_slots == 0;
      const uint ray_block0 = blocks ? row0 / SIM_BLOCK_SIDE * SIM_TILE_BLOCKS : row0 * frame.row_slots;
      const uint ray_block1 =
          blocks ? (row1 / SIM_BLOCK_SIDE + 1) * SIM_TILE_BLOCKS - 1 : (row1 + 1) * frame.row_slots - 1;
      const uint packed = particle | ray_block0 << SIM_PARTICLE_BITS | ray_block1 << (SIM_PARTICLE_BITS + 4);
      SIM_EACH(part, 2) {
        const uint columns = part == 0 ? f.columns : f.others;
        const uint begin = ty * frame.tiles_x + SIM_TILE_COLUMN(columns), first_place = place;
        for (uint k = 0; k < SIM_HIGH(columns); ++k) {
          tile[place] = begin + k;
          payload[place] = packed;
          ++place;
        }
        if (!blocks || place == first_place) continue;
        // Of the first and the last tile not all columns of blocks.
        payload[first_place] += SIM_FIRST_IN_TILE(columns) << SIM_PARTICLE_BITS;
        payload[place - 1] -= (SIM_TILE_BLOCKS - 1 - SIM_LAST_IN_TILE(columns)) << (SIM_PARTICLE_BITS + 4);
      }
    }
  }
}

/// in  tile[K]: sorted
/// out first[tiles + 1]: pairs of tile t are [first[t], first[t+1])
__kernel SIM_GROUP void tile_ranges(
    __global const uint* tile, const uint k, const uint chunk, const uint tiles, __global uint* first) {
  const uint begin = min((uint)get_global_id(0) * chunk, k);
  const uint end = min(begin + chunk, k);
  // The work-item that owns pair i opens every tile after that of pair i-1 up to its own.
  for (uint i = begin; i < end; ++i) {
    const uint here = tile[i];
    const uint from = i == 0 ? 0 : tile[i - 1] + 1;
    for (uint t = from; t <= here; ++t) first[t] = i;
  }
  // The last pair's owner opens those that follow it; of none, the first work-item opens all.
  if (k == 0 ? get_global_id(0) == 0 : begin < end && end == k) {
    const uint from = k == 0 ? 0 : tile[k - 1] + 1;
    for (uint t = from; t <= tiles; ++t) first[t] = k;
  }
}

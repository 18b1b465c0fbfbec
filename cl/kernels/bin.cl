// bin.cl - visible particles -> tile-Gaussian pairs -> tile ranges. Launcher: host/device/render/frame/bin.cpp
// Every work-item owns `chunk` consecutive elements: CPUs run few work-items with long loops, GPUs many with
// short loops in groups of LS. All orders depend on the input only, not on scheduling.
#include "math/lanes.h"
#include "shared/cluster.h"
#include "shared/layout.h"

/// Returns the end of the cluster that contains element i, at most `last`.
FN uint cluster_end(uint i, uint last) { return min((i / SIM_CLUSTER + 1) * SIM_CLUSTER, last); }

/// Returns the offset from elements of i's cluster to their particles.
FN uint cluster_shift(uint paged, __global const uint* cluster_at, uint i) {
  const uint cluster = i / SIM_CLUSTER;
  return paged ? (cluster_at[cluster] - cluster) * SIM_CLUSTER : 0;
}

/// Counts visible particles and their pairs.
/// in  keys[n]; live[clusters]: 0 if all particles of a cluster are culled
///     footprints[n]; with `paged` cluster_at[clusters] as in project.cl: keys and footprints are then indexed
///         by particle
/// out counts[2][work-items]: visible particles of each chunk, and their pairs, 0xffffffff if the pairs exceed
///     32 bits, so that both sums are known before sorting
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

/// Writes the visible particles in frame order.
/// in  offsets[work-items]: exclusive prefix sum of counts
/// out visible_keys, visible[M]: range keys and indices of the visible particles
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

/// Counts the pairs of each chunk of sorted particles.
/// in  order[M]: visible particles by range
/// out counts[work-items]: pairs of each chunk; the total fits 32 bits
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
/// out tile[K]; payload[K]: particle | first ray block << 24 | last ray block << 28; for cameras the blocks in
///     two opposite corners
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
        // The first and the last tile contain only part of the block columns.
        payload[first_place] += SIM_FIRST_IN_TILE(columns) << SIM_PARTICLE_BITS;
        payload[place - 1] -= (SIM_TILE_BLOCKS - 1 - SIM_LAST_IN_TILE(columns)) << (SIM_PARTICLE_BITS + 4);
      }
    }
  }
}

/// Finds the pairs of each tile.
/// in  tile[K]: sorted
/// out first[tiles + 1]: tile t has the pairs [first[t], first[t+1])
__kernel SIM_GROUP void tile_ranges(
    __global const uint* tile, const uint k, const uint chunk, const uint tiles, __global uint* first) {
  const uint begin = min((uint)get_global_id(0) * chunk, k);
  const uint end = min(begin + chunk, k);
  // The work-item of pair i writes the starts of all tiles after that of pair i-1 up to its own.
  for (uint i = begin; i < end; ++i) {
    const uint here = tile[i];
    const uint from = i == 0 ? 0 : tile[i - 1] + 1;
    for (uint t = from; t <= here; ++t) first[t] = i;
  }
  // The owner of the last pair writes the remaining starts; without pairs the first work-item writes all.
  if (k == 0 ? get_global_id(0) == 0 : begin < end && end == k) {
    const uint from = k == 0 ? 0 : tile[k - 1] + 1;
    for (uint t = from; t <= tiles; ++t) first[t] = k;
  }
}

// sort.cl - stable LSD radix sort of (key, value) pairs. Launcher: host/render/device/sort.cpp
// A work-group owns `block` consecutive pairs. CPU: groups of one work-item, 11 bits a pass. GPU: 8 bits; a group
// puts a tile of its pairs after the other in order in local memory, so that neighbours write to neighbours.
// Stable, and nothing depends on the order in which work-items run, hence reproducible.
#include "math/group.h"
#include "math/lanes.h"

#define DIGITS (1 << RADIX_BITS)

/// Pairs of the group: [begin, end).
#define GROUP_RANGE                         \
  const uint group = get_group_id(0);       \
  const uint groups = get_num_groups(0);    \
  const uint begin = min(group * block, n); \
  const uint end = min(begin + block, n);

/// out histogram[digit][group]: pairs of each group with that digit.
__kernel SIM_GROUP void radix_count(
    __global const uint* keys, const uint n, const uint block, const uint shift, __global uint* histogram) {
  __local uint count[DIGITS];
  GROUP_RANGE
  const uint lid = get_local_id(0);
  for (uint d = lid; d < DIGITS; d += LS) count[d] = 0;
#if LS > 1
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint i = begin + lid; i < end; i += LS) atomic_inc(&count[keys[i] >> shift & (DIGITS - 1)]);
  barrier(CLK_LOCAL_MEM_FENCE);
#else
  for (uint i = begin; i < end; ++i) ++count[keys[i] >> shift & (DIGITS - 1)];
#endif
  for (uint d = lid; d < DIGITS; d += LS) histogram[d * groups + group] = count[d];
}

#if LS > 1
#define OWN 4  // consecutive pairs of a tile that each work-item orders
#define TILE (OWN * LS)
#define NIBBLES 16  // digits of 4 bits: two rounds order a tile by 8

/// Orders a tile by the 4 bits at `shift`, stably.
/// in  own[OWN], place[OWN]: keys of the tile at OWN * lid, and where in the tile they came from
/// out keys[TILE], from[TILE]: the same of the whole tile, in order
/// count[NIBBLES * LS], sums[LS]: for the way
FN void order_tile(const uint* own,
                   const uint* place,
                   const uint shift,
                   __local uint* keys,
                   __local ushort* from,
                   __local ushort* count,
                   __local uint* sums) {
  const uint lid = get_local_id(0);
  for (uint d = 0; d < NIBBLES; ++d) count[d * LS + lid] = 0;
#pragma unroll
  for (uint j = 0; j < OWN; ++j) ++count[(own[j] >> shift & (NIBBLES - 1)) * LS + lid];
  barrier(CLK_LOCAL_MEM_FENCE);
  // Counters by digit, then by work-item: each work-item adds up NIBBLES that follow each other.
  uint sum = 0, total;
  for (uint k = 0; k < NIBBLES; ++k) sum += count[lid * NIBBLES + k];
  uint before = group_sum_before_uint(sum, sums, &total);
  for (uint k = 0; k < NIBBLES; ++k) {
    const uint here = count[lid * NIBBLES + k];
    count[lid * NIBBLES + k] = (ushort)before;
    before += here;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
#pragma unroll
  for (uint j = 0; j < OWN; ++j) {
    const uint to = count[(own[j] >> shift & (NIBBLES - 1)) * LS + lid]++;
    keys[to] = own[j];
    from[to] = (ushort)place[j];
  }
  barrier(CLK_LOCAL_MEM_FENCE);
}
#endif

/// in  base[digit][group]: exclusive prefix sum of the histogram
/// out sorted pairs; pairs of equal digit keep their order
__kernel SIM_GROUP void radix_scatter(__global const uint* keys,
                                      __global const uint* values,
                                      const uint n,
                                      const uint block,
                                      const uint shift,
                                      __global const uint* base,
                                      __global uint* keys_out,
                                      __global uint* values_out) {
  __local uint next[DIGITS];
#if LS > 1
  __local uint tile_keys[TILE];
  __local ushort tile_from[TILE];
  __local ushort count[NIBBLES * LS];
  __local uint sums[LS];
#endif
  GROUP_RANGE
  const uint lid = get_local_id(0);
  for (uint d = lid; d < DIGITS; d += LS) next[d] = base[d * groups + group];
#if LS > 1
  for (uint tile = begin; tile < end; tile += TILE) {
    const uint here = min(end - tile, (uint)TILE);
    uint own[OWN], place[OWN];
    for (uint i = lid; i < TILE; i += LS) tile_keys[i] = i < here ? keys[tile + i] : 0xffffffffu;
    barrier(CLK_LOCAL_MEM_FENCE);
#pragma unroll
    for (uint j = 0; j < OWN; ++j) {
      place[j] = OWN * lid + j;
      own[j] = tile_keys[place[j]];
    }
    order_tile(own, place, shift, tile_keys, tile_from, count, sums);
#pragma unroll
    for (uint j = 0; j < OWN; ++j) {
      own[j] = tile_keys[OWN * lid + j];
      place[j] = tile_from[OWN * lid + j];
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    order_tile(own, place, shift + 4, tile_keys, tile_from, count, sums);

    // What fills up a last tile comes last: its digit is the greatest, and it follows all others that have it.
    for (uint i = lid; i < here; i += LS) {
      const uint digit = tile_keys[i] >> shift & (DIGITS - 1);
      // The first of each digit: from here on next[] is where the tile's place 0 would go.
      if (i == 0 || (tile_keys[i - 1] >> shift & (DIGITS - 1)) != digit) next[digit] -= i;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint i = lid; i < here; i += LS) {
      const uint key = tile_keys[i];
      const uint to = next[key >> shift & (DIGITS - 1)] + i;
      keys_out[to] = key;
      values_out[to] = values[tile + tile_from[i]];
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint i = lid; i < here; i += LS) {
      const uint digit = tile_keys[i] >> shift & (DIGITS - 1);
      if (i + 1 == here || (tile_keys[i + 1] >> shift & (DIGITS - 1)) != digit) next[digit] += i + 1;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
  }
#else
  for (uint i = begin; i < end; ++i) {
    const uint key = keys[i];
    const uint place = next[key >> shift & (DIGITS - 1)]++;
    keys_out[place] = key;
    values_out[place] = values[i];
  }
#endif
}

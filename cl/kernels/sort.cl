// sort.cl - stable LSD radix sort of (key, value) pairs. Launcher: host/device/render/device/sort.cpp
// A work-group owns `block` consecutive pairs. CPU: groups of one work-item, 11 bits a pass. GPU: 8 bits a
// pass; a group sorts its pairs tile by tile in local memory, so that neighbours write to neighbouring
// addresses. The sort is stable and does not depend on the order in which work-items run.
#include "math/group.h"
#include "math/lanes.h"

#define SIM_SORT_DIGITS (1 << RADIX_BITS)

/// Pairs of the group: [begin, end).
#define SIM_SORT_GROUP_RANGE                \
  const uint group = get_group_id(0);       \
  const uint groups = get_num_groups(0);    \
  const uint begin = min(group * block, n); \
  const uint end = min(begin + block, n);

/// out histogram[digit][group]: pairs of each group with that digit
__kernel SIM_GROUP void radix_count(
    __global const uint* keys, const uint n, const uint block, const uint shift, __global uint* histogram) {
  __local uint count[SIM_SORT_DIGITS];
  SIM_SORT_GROUP_RANGE
  const uint lid = get_local_id(0);
  for (uint d = lid; d < SIM_SORT_DIGITS; d += LS) count[d] = 0;
#if LS > 1
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint i = begin + lid; i < end; i += LS) atomic_inc(&count[keys[i] >> shift & (SIM_SORT_DIGITS - 1)]);
  barrier(CLK_LOCAL_MEM_FENCE);
#else
  for (uint i = begin; i < end; ++i) ++count[keys[i] >> shift & (SIM_SORT_DIGITS - 1)];
#endif
  for (uint d = lid; d < SIM_SORT_DIGITS; d += LS) histogram[d * groups + group] = count[d];
}

#if LS > 1
#define SIM_SORT_OWN 4  // consecutive pairs of a tile sorted by each work-item
#define SIM_SORT_TILE (SIM_SORT_OWN * LS)
#define SIM_SORT_NIBBLES 16  // digits of 4 bits: two rounds sort a tile by 8 bits

/// Sorts a tile stably by the 4 bits at `shift`.
/// in  own[SIM_SORT_OWN], place[SIM_SORT_OWN]: the tile's keys at SIM_SORT_OWN * lid, and their original
///     positions in the tile
/// out keys[SIM_SORT_TILE], from[SIM_SORT_TILE]: the sorted keys of the whole tile and their original positions
/// scratch count[SIM_SORT_NIBBLES * LS], sums[LS]
FN void order_tile(const uint* own,
                   const uint* place,
                   const uint shift,
                   __local uint* keys,
                   __local ushort* from,
                   __local ushort* count,
                   __local uint* sums) {
  const uint lid = get_local_id(0);
  for (uint d = 0; d < SIM_SORT_NIBBLES; ++d) count[d * LS + lid] = 0;
  SIM_EACH(j, SIM_SORT_OWN) ++count[(own[j] >> shift & (SIM_SORT_NIBBLES - 1)) * LS + lid];
  barrier(CLK_LOCAL_MEM_FENCE);
  // Counters by digit, then by work-item: each work-item sums SIM_SORT_NIBBLES consecutive counters.
  uint sum = 0, total;
  for (uint k = 0; k < SIM_SORT_NIBBLES; ++k) sum += count[lid * SIM_SORT_NIBBLES + k];
  uint before = group_sum_before_uint(sum, sums, &total);
  for (uint k = 0; k < SIM_SORT_NIBBLES; ++k) {
    const uint here = count[lid * SIM_SORT_NIBBLES + k];
    count[lid * SIM_SORT_NIBBLES + k] = (ushort)before;
    before += here;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  SIM_EACH(j, SIM_SORT_OWN) {
    const uint to = count[(own[j] >> shift & (SIM_SORT_NIBBLES - 1)) * LS + lid]++;
    keys[to] = own[j];
    from[to] = (ushort)place[j];
  }
  barrier(CLK_LOCAL_MEM_FENCE);
}
#endif

/// Writes pairs to their sorted positions; pairs of equal digit keep their order.
/// in  base[digit][group]: exclusive prefix sum of the histogram
/// out sorted pairs
__kernel SIM_GROUP void radix_scatter(__global const uint* keys,
                                      __global const uint* values,
                                      const uint n,
                                      const uint block,
                                      const uint shift,
                                      __global const uint* base,
                                      __global uint* keys_out,
                                      __global uint* values_out) {
  __local uint next[SIM_SORT_DIGITS];
#if LS > 1
  __local uint tile_keys[SIM_SORT_TILE];
  __local ushort tile_from[SIM_SORT_TILE];
  __local ushort count[SIM_SORT_NIBBLES * LS];
  __local uint sums[LS];
#endif
  SIM_SORT_GROUP_RANGE
  const uint lid = get_local_id(0);
  for (uint d = lid; d < SIM_SORT_DIGITS; d += LS) next[d] = base[d * groups + group];
#if LS > 1
  for (uint tile = begin; tile < end; tile += SIM_SORT_TILE) {
    const uint here = min(end - tile, (uint)SIM_SORT_TILE);
    uint own[SIM_SORT_OWN], place[SIM_SORT_OWN];
    for (uint i = lid; i < SIM_SORT_TILE; i += LS) tile_keys[i] = i < here ? keys[tile + i] : 0xffffffffu;
    barrier(CLK_LOCAL_MEM_FENCE);
    SIM_EACH(j, SIM_SORT_OWN) {
      place[j] = SIM_SORT_OWN * lid + j;
      own[j] = tile_keys[place[j]];
    }
    order_tile(own, place, shift, tile_keys, tile_from, count, sums);
    SIM_EACH(j, SIM_SORT_OWN) {
      own[j] = tile_keys[SIM_SORT_OWN * lid + j];
      place[j] = tile_from[SIM_SORT_OWN * lid + j];
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    order_tile(own, place, shift + 4, tile_keys, tile_from, count, sums);

    // Padding of a last tile sorts last: its digit is the largest, and it follows all other pairs of that
    // digit.
    for (uint i = lid; i < here; i += LS) {
      const uint digit = tile_keys[i] >> shift & (SIM_SORT_DIGITS - 1);
      // First entry of each digit: from here on next[] is the target of the tile's position 0.
      if (i == 0 || (tile_keys[i - 1] >> shift & (SIM_SORT_DIGITS - 1)) != digit) next[digit] -= i;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint i = lid; i < here; i += LS) {
      const uint key = tile_keys[i];
      const uint to = next[key >> shift & (SIM_SORT_DIGITS - 1)] + i;
      keys_out[to] = key;
      values_out[to] = values[tile + tile_from[i]];
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint i = lid; i < here; i += LS) {
      const uint digit = tile_keys[i] >> shift & (SIM_SORT_DIGITS - 1);
      if (i + 1 == here || (tile_keys[i + 1] >> shift & (SIM_SORT_DIGITS - 1)) != digit) next[digit] += i + 1;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
  }
#else
  for (uint i = begin; i < end; ++i) {
    const uint key = keys[i];
    const uint place = next[key >> shift & (SIM_SORT_DIGITS - 1)]++;
    keys_out[place] = key;
    values_out[place] = values[i];
  }
#endif
}

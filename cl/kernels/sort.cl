// sort.cl - stable LSD radix sort of (key, value) pairs. Launcher: host/render/device/sort.cpp
// A work-group owns `block` consecutive pairs, a work-item consecutive pairs of those. CPU: groups of one
// work-item, 11 bits; GPU: 64 work-items, 4 bits. Stable and free of atomics, hence reproducible.
#include "math/lanes.h"

#define DIGITS (1 << RADIX_BITS)

/// Pairs of work-item `lid` in group `group`: [first, last).
#define OWN_RANGE                                              \
  const uint lid = get_local_id(0);                            \
  const uint group = get_group_id(0);                          \
  const uint groups = get_num_groups(0);                       \
  const uint begin = min(group * block, n);                    \
  const uint end = min(begin + block, n);                      \
  const uint own = (end - begin + LS - 1) / LS;                \
  const uint first = min(begin + lid * own, end);              \
  const uint last = min(first + own, end);

/// out histogram[digit][group]: pairs of each group with that digit.
__kernel GROUP void radix_count(__global const uint* keys,
                          const uint n,
                          const uint block,
                          const uint shift,
                          __global uint* histogram) {
  __local uint count[DIGITS * LS];
  OWN_RANGE
  for (uint d = 0; d < DIGITS; ++d) count[d * LS + lid] = 0;
  for (uint i = first; i < last; ++i) ++count[(keys[i] >> shift & (DIGITS - 1)) * LS + lid];
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint d = lid; d < DIGITS; d += LS) {
    uint sum = 0;
    for (uint k = 0; k < LS; ++k) sum += count[d * LS + k];
    histogram[d * groups + group] = sum;
  }
}

/// in  base[digit][group]: exclusive prefix sum of the histogram
/// out sorted pairs; pairs of equal digit keep their order
__kernel GROUP void radix_scatter(__global const uint* keys,
                            __global const uint* values,
                            const uint n,
                            const uint block,
                            const uint shift,
                            __global const uint* base,
                            __global uint* keys_out,
                            __global uint* values_out) {
  __local uint next[DIGITS * LS];
  OWN_RANGE
#if LS > 1
  for (uint d = 0; d < DIGITS; ++d) next[d * LS + lid] = 0;
  for (uint i = first; i < last; ++i) ++next[(keys[i] >> shift & (DIGITS - 1)) * LS + lid];
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint d = lid; d < DIGITS; d += LS) {
    uint place = base[d * groups + group];
    for (uint k = 0; k < LS; ++k) {
      const uint here = next[d * LS + k];
      next[d * LS + k] = place;
      place += here;
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE);
#else
  for (uint d = 0; d < DIGITS; ++d) next[d] = base[d * groups + group];
#endif
  for (uint i = first; i < last; ++i) {
    const uint key = keys[i];
    const uint place = next[(key >> shift & (DIGITS - 1)) * LS + lid]++;
    keys_out[place] = key;
    values_out[place] = values[i];
  }
}

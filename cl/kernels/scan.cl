// scan.cl - exclusive prefix sum. Launcher: host/device/render/device/scan.cpp
// A work-group owns `block` consecutive elements, a work-item a consecutive part of those. CPUs: one group of
// one work-item; GPUs: as many groups as the elements fill.
#include "math/group.h"
#include "math/lanes.h"

/// Elements of this work-item: [first, last).
#define SIM_SCAN_OWN_RANGE                                  \
  const uint lid = get_local_id(0);                         \
  const uint begin = min((uint)get_group_id(0) * block, n); \
  const uint end = min(begin + block, n);                   \
  const uint own = (end - begin + LS - 1) / LS;             \
  const uint first = min(begin + lid * own, end);           \
  const uint last = min(first + own, end);

/// out sums[groups]: sum of each group's elements
__kernel SIM_GROUP void scan_sums(__global const uint* data,
                                  const uint n,
                                  const uint block,
                                  __global ulong* sums) {
  __local ulong parts[LS];
  SIM_SCAN_OWN_RANGE
  ulong sum = 0, total;
  for (uint i = first; i < last; ++i) sum += data[i];
  group_sum_before_ulong(sum, parts, &total);
  if (lid == 0) sums[get_group_id(0)] = total;
}

/// Replaces data[n] by its exclusive prefix sum.
/// in  sums[groups] of scan_sums(), unused with one group; middle: an element index, or n for none
/// out total[2]: 64-bit sum of all elements, and of all before `middle`
__kernel SIM_GROUP void scan_exclusive(__global uint* data,
                                       const uint n,
                                       const uint block,
                                       const uint middle,
                                       __global const ulong* sums,
                                       __global ulong* total) {
  __local ulong parts[LS];
  SIM_SCAN_OWN_RANGE
  ulong earlier = 0, own_groups = 0;
  for (uint g = lid; g < get_group_id(0); g += LS) own_groups += sums[g];
  group_sum_before_ulong(own_groups, parts, &earlier);

  ulong sum = 0, of_group;
  for (uint i = first; i < last; ++i) sum += data[i];
  ulong before = earlier + group_sum_before_ulong(sum, parts, &of_group);
  if (lid == 0 && get_group_id(0) == get_num_groups(0) - 1) total[0] = earlier + of_group;
  for (uint i = first; i < last; ++i) {
    const uint value = data[i];
    data[i] = (uint)before;
    before += value;
  }
  if (first <= middle && middle < last) total[1] = data[middle];
}

// group.h - sums over the LS work-items of a group.
#ifndef SIMULI_CL_MATH_GROUP_H
#define SIMULI_CL_MATH_GROUP_H

#include "math/lanes.h"

#if LS > 1
// Doubles the distance in each step (Hillis and Steele, CACM 29(12), 1986): log2(LS) steps with all work-items
// busy.
#define GROUP_SUM(T)                                                    \
  FN T group_sum_before_##T(const T value, __local T* sums, T* total) { \
    const uint lid = get_local_id(0);                                   \
    sums[lid] = value;                                                  \
    barrier(CLK_LOCAL_MEM_FENCE);                                       \
    for (uint apart = 1; apart < LS; apart <<= 1) {                     \
      const T other = lid >= apart ? sums[lid - apart] : 0;             \
      barrier(CLK_LOCAL_MEM_FENCE);                                     \
      sums[lid] += other;                                               \
      barrier(CLK_LOCAL_MEM_FENCE);                                     \
    }                                                                   \
    const T before = lid > 0 ? sums[lid - 1] : 0;                       \
    *total = sums[LS - 1];                                              \
    barrier(CLK_LOCAL_MEM_FENCE);                                       \
    return before;                                                      \
  }
#else
#define GROUP_SUM(T)                                                    \
  FN T group_sum_before_##T(const T value, __local T* sums, T* total) { \
    *total = value;                                                     \
    return 0;                                                           \
  }
#endif

/// Sum of `value` over the work-items before this one, and over the whole group. sums[LS] may be reused
/// immediately. All work-items must call it.
GROUP_SUM(uint)
GROUP_SUM(ulong)

#if LS > 1
/// out[columns]: group sums of each work-item's own[columns], column by column. parts[LS][columns].
FN void group_columns(const real* own, const uint columns, __local real* parts, __global real* out) {
  const uint lid = get_local_id(0);
#pragma unroll
  for (uint k = 0; k < columns; ++k) parts[lid * columns + k] = own[k];
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint k = lid; k < columns; k += LS) {
    real sum = R(0.0);
    for (uint w = 0; w < LS; ++w) sum += parts[w * columns + k];
    out[k] = sum;
  }
}
#endif

#endif

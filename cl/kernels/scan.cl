// scan.cl - exclusive prefix sum by one work-group. Launcher: host/render/device/scan.cpp
#include "math/lanes.h"

/// data[n] becomes its exclusive prefix sum; total[0] the sum in 64 bits. One work-group of LS work-items,
/// each over consecutive elements, so that barriers are few: launch with global = local = LS.
__kernel GROUP void scan_exclusive(__global uint* data, const uint n, __global ulong* total) {
  __local ulong sums[LS];
  const uint lid = get_local_id(0);
  const uint chunk = (n + LS - 1) / LS;
  const uint first = min(lid * chunk, n);
  const uint last = min(first + chunk, n);
  ulong sum = 0;
  for (uint i = first; i < last; ++i) sum += data[i];
  sums[lid] = sum;
  barrier(CLK_LOCAL_MEM_FENCE);
  ulong before = 0;
  for (uint k = 0; k < lid; ++k) before += sums[k];
  if (lid == LS - 1) total[0] = before + sum;
  for (uint i = first; i < last; ++i) {
    const uint value = data[i];
    data[i] = (uint)before;
    before += value;
  }
}

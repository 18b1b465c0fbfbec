// shard_sum.cl - gradients of frames, one frame after the other. Launcher: host/render/train/shard_sum.cpp
// A matrix [rows][stride] has a column for each particle; a frame has a say in some of them alone, which are
// listed. No column is listed twice, so no two work-items touch one number: what a sum is depends on the order of
// the launches, and on nothing else.
#include "math/lanes.h"

/// in  order[count]: columns
/// out packed[rows][count]: what stands in them
__kernel void pack_columns(const uint count,
                           const uint rows,
                           const uint stride,
                           __global const uint* order,
                           __global const real* from,
                           __global real* packed) {
  const uint k = get_global_id(0);
  if (k >= count) return;
  const uint i = order[k];
  for (uint row = 0; row < rows; ++row) packed[(ulong)row * count + k] = from[(ulong)row * stride + i];
}

/// Adds `share` times the columns of a frame, each sum rounded once.
/// in  order[count], not read without `listed`: then the columns are 0, 1, ...
///     from: [rows][count] where they are `packed`, else [rows][stride]
/// io  sum[rows][stride]
__kernel void add_columns(const uint count,
                          const uint rows,
                          const uint stride,
                          const uint listed,
                          const uint packed,
                          const real share,
                          __global const uint* order,
                          __global const real* from,
                          __global real* sum) {
  const uint k = get_global_id(0);
  if (k >= count) return;
  const uint i = listed ? order[k] : k;
  const uint at = packed ? k : i, width = packed ? count : stride;
  for (uint row = 0; row < rows; ++row) {
    const ulong to = (ulong)row * stride + i;
    sum[to] = fma(share, from[(ulong)row * width + at], sum[to]);
  }
}

/// keys[i] = 0 of all that are listed: some frame shows them.
__kernel void mark_columns(const uint count, __global const uint* order, __global uint* keys) {
  const uint k = get_global_id(0);
  if (k < count) keys[order[k]] = 0;
}

// shard_sum.cl - sums the gradients of a step's frames by a tree. Launcher: host/device/render/train/shard_sum.cpp
// A matrix [rows][stride] has one column per particle; a frame, or a sum of frames, has values only in columns
// whose key is not all ones. No launch accesses a number twice, and every addition rounds the sum of two stored
// numbers once, so a sum depends only on the structure of the tree.
#include "math/lanes.h"

/// Adds `share` times a matrix to a sum, or copies it to columns where the sum has no values yet. V columns per
/// work-item.
/// in  from_keys[particles], from[rows][stride]
/// io  keys[particles] of the sum, with `mark` set to 0 where `from` has values; sum[first + rows][stride],
/// from row `first` on
__kernel void add_rendered(const uint particles,
                           const uint stride,
                           const uint rows,
                           const uint first,
                           const uint mark,
                           const real share,
                           __global const uint* from_keys,
                           __global const real* from,
                           __global uint* keys,
                           __global real* sum) {
  const uint column = get_global_id(0) * V;
  if (column >= particles) return;
  real shown[V], stood[V];
  uint any_shown = 0;
  SIM_EACH(lane, V) {
    const uint i = min(column + lane, particles - 1);
    const uint is_shown = column + lane < particles && from_keys[i] != 0xffffffffu;
    shown[lane] = is_shown ? R(1.0) : R(0.0);
    stood[lane] = keys[i] != 0xffffffffu ? R(1.0) : R(0.0);
    any_shown |= is_shown;
  }
  if (!any_shown) return;
  const I is_shown = LDV(shown) > R(0.5), has_stood = LDV(stood) > R(0.5);
  for (uint row = 0; row < rows; ++row) {
    const ulong to = (ulong)(first + row) * stride + column;
    const F more = share * LDV(from + (ulong)row * stride + column);
    const F old = LDV(sum + to);
    STV(sum + to, SEL(is_shown, SEL(has_stood, old + more, more), old));
  }
  if (!mark) return;
  SIM_EACH(lane, V) {
    if (shown[lane] > R(0.5)) keys[column + lane] = 0;
  }
}

/// Packs columns. V of the columns in order[count] per work-item.
/// out packed[rows][count]
__kernel void pack_columns(const uint count,
                           const uint rows,
                           const uint stride,
                           __global const uint* order,
                           __global const real* sum,
                           __global real* packed) {
  const uint first = get_global_id(0) * V;
  for (uint row = 0; row < rows; ++row) {
    for (uint k = first; k < min(first + V, count); ++k) {
      packed[(ulong)row * count + k] = sum[(ulong)row * stride + order[k]];
    }
  }
}

/// Adds packed columns, as add_rendered() with a share of 1 and all rows.
/// in  packed[rows][count]
/// io  keys[particles], sum[rows][stride]
__kernel void add_packed(const uint count,
                         const uint rows,
                         const uint stride,
                         __global const uint* order,
                         __global const real* packed,
                         __global uint* keys,
                         __global real* sum) {
  const uint first = get_global_id(0) * V;
  for (uint row = 0; row < rows; ++row) {
    for (uint k = first; k < min(first + V, count); ++k) {
      const ulong to = (ulong)row * stride + order[k];
      const real more = packed[(ulong)row * count + k];
      sum[to] = keys[order[k]] != 0xffffffffu ? sum[to] + more : more;
    }
  }
  for (uint k = first; k < min(first + V, count); ++k) keys[order[k]] = 0;
}

/// sum[i] += sums[row][i] for particles visible by `keys`.
__kernel void add_row(const uint particles,
                      const uint stride,
                      const uint row,
                      __global const uint* keys,
                      __global const real* sums,
                      __global real* sum) {
  const uint i = get_global_id(0);
  if (i < particles && keys[i] != 0xffffffffu) sum[i] += sums[(ulong)row * stride + i];
}

/// sum[i] += share from[i], rounded once.
__kernel void add_all(const uint count, const real share, __global const real* from, __global real* sum) {
  const uint i = get_global_id(0);
  if (i < count) sum[i] = fma(share, from[i], sum[i]);
}

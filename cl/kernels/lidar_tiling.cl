// lidar_tiling.cl - assigns a LiDAR's rays to tiles of few rays each (procedure 1). Launcher: host/device/render/rays/lidar_tiling.cpp
// Runs once per sensor. The bin of a value is floor((value - first) * scale), limited to `bins`. Rows run from
// top to bottom, bins and elevation tiles from the lowest value up, tile rows from top to bottom. All decisions
// are made on integers: the same rays give the same tiles on every device that rounds (value - first) * scale
// alike.
#include "math/lanes.h"
#include "shared/layout.h"

FN uint tiling_bin(float value, float first, float scale, uint bins) {
  const float bin = (value - first) * scale;
  return (uint)max(min(bin, (float)bins - 1.0f), 0.0f);
}

/// Adds up a histogram.
/// in  values[n], each representing `weight` rays; group_of_bin[bins]
/// out counts[groups]: rays of each group are added
__kernel void tiling_histogram(__global const float* values,
                               const uint n,
                               const uint weight,
                               const float first,
                               const float scale,
                               const uint bins,
                               __global const uint* group_of_bin,
                               __global uint* counts) {
  const uint i = get_global_id(0);
  if (i < n) atomic_add(counts + group_of_bin[tiling_bin(values[i], first, scale, bins)], weight);
}

/// Cuts bins into groups with equal numbers of rays: after each bin where the cumulative share of rays times
/// `wanted` passes an integer. Several integers in one bin give one boundary. One work-item.
/// in  before[bins]: rays of all lower bins; widest: largest number of bins in a group
/// out group_of_bin[bins], consecutive from 0; groups[1]: number of groups
__kernel void tiling_boundaries(__global const uint* before,
                                const uint rays,
                                const uint bins,
                                const uint wanted,
                                const uint widest,
                                __global uint* group_of_bin,
                                __global uint* groups) {
  uint group = 0, start = 0;
  ulong next = 1;
  for (uint i = 0; i < bins; ++i) {
    group_of_bin[i] = group;
    const uint after = i + 1 < bins ? before[i + 1] : rays;
    const ulong reached = (ulong)after * wanted;
    const int full = reached >= next * rays && after < rays;
    if (full) next = reached / rays + 1;
    if ((full || i + 1 - start >= widest) && i + 1 < bins) {
      ++group;
      start = i + 1;
    }
  }
  groups[0] = group + 1;
}

/// Finds the elevation group of each row.
/// in  row_elevation[rows]
/// out group_of_row[rows]
__kernel void tiling_row_groups(__global const float* row_elevation,
                                const uint rows,
                                const float first,
                                const float scale,
                                const uint bins,
                                __global const uint* group_of_bin,
                                __global uint* group_of_row) {
  const uint row = get_global_id(0);
  if (row < rows) group_of_row[row] = group_of_bin[tiling_bin(row_elevation[row], first, scale, bins)];
}

/// Sort keys with the highest elevation first.
__kernel void tiling_keys(__global const float* elevation,
                          const uint n,
                          __global uint* keys,
                          __global uint* order) {
  const uint i = get_global_id(0);
  if (i >= n) return;
  const uint bits = as_uint(elevation[i]);
  keys[i] = bits >> 31 ? bits : 0x7fffffffu - bits;
  order[i] = i;
}

/// Cuts rays that have no rows, from top to bottom, into rows: at the boundaries of elevation groups, and wherever
/// a tile column of the row holds `width` rays. One work-item.
/// in  order[n]: rays by falling elevation; column_of_bin[x_bins] of x; group_of_bin[bins] of elevations
/// out row_starts[rows + 1]: first ray of each row, as an index into `order`; group_of_row[rows]: elevation group
///     rows[1]: their number; most_rows + 1 where there are more than most_rows
/// scratch used[2][columns]
__kernel void tiling_list_rows(__global const uint* order,
                               const uint n,
                               __global const float* x,
                               const float x_first,
                               const float x_scale,
                               const uint x_bins,
                               __global const uint* column_of_bin,
                               const uint columns,
                               __global const float* elevation,
                               const float first,
                               const float scale,
                               const uint bins,
                               __global const uint* group_of_bin,
                               const uint width,
                               const uint most_rows,
                               __global uint* used,
                               __global uint* row_starts,
                               __global uint* group_of_row,
                               __global uint* rows) {
  for (uint c = 0; c < 2 * columns; ++c) used[c] = 0;
  uint row = 0, group = 0;
  for (uint i = 0; i < n; ++i) {
    const uint ray = order[i];
    const uint own = group_of_bin[tiling_bin(elevation[ray], first, scale, bins)];
    const uint c = column_of_bin[tiling_bin(x[ray], x_first, x_scale, x_bins)];
    // used[c] counts the rays of row used[columns + c] (from 1) in tile column c.
    const uint full = used[columns + c] == row && used[c] == width;
    if (i == 0 || own != group || full) {
      if (row == most_rows) {
        rows[0] = most_rows + 1;
        return;
      }
      row_starts[row] = i;
      group_of_row[row] = group = own;
      ++row;
    }
    used[c] = used[columns + c] == row ? used[c] + 1 : 1;
    used[columns + c] = row;
  }
  row_starts[row] = n;
  rows[0] = row;
}

/// Cuts the rows of each elevation group into tile rows; a group with more than `most` rows is divided evenly.
/// One work-item.
/// in  group_of_row[rows]
/// out tile_rows[tile rows + 1]: first row of each; tile_row_of_row[rows]
///     found[3]: number of tile rows; rows of the largest; rows of the smallest
__kernel void tiling_tile_rows(__global const uint* group_of_row,
                               const uint rows,
                               const uint most,
                               __global uint* tile_rows,
                               __global uint* tile_row_of_row,
                               __global uint* found) {
  uint tiles = 0, largest = 0, smallest = rows;
  for (uint start = 0; start < rows;) {
    uint end = start + 1;
    while (end < rows && group_of_row[end] == group_of_row[start]) ++end;
    const uint parts = (end - start + most - 1) / most;
    for (uint part = 0; part < parts; ++part) {
      const uint from = start + (end - start) * part / parts;
      const uint to = start + (end - start) * (part + 1) / parts;
      for (uint row = from; row < to; ++row) tile_row_of_row[row] = tiles;
      tile_rows[tiles++] = from;
      largest = max(largest, to - from);
      smallest = min(smallest, to - from);
    }
    start = end;
  }
  tile_rows[tiles] = rows;
  found[0] = tiles;
  found[1] = largest;
  found[2] = smallest;
}

/// Computes the slot of each ray from its tile, the slots of its row in the tile, and its position among the
/// row's rays in the tile. One work-item per row.
/// in  x[n]; order[n]: rays by row; row_starts[rows + 1]: first ray of each row, as an index into `order`
///     column_of_bin[bins]; tile_rows, tile_row_of_row of tiling_tile_rows; width: slots of a row in a tile
/// out slot_of_ray[n]: invalid where a value of `fullest` exceeds `width`
///     used[rows][columns]: rays of each row in each tile column; fullest[rows]: the largest value of used[row]
__kernel void tiling_slots(__global const float* x,
                           __global const uint* order,
                           __global const uint* row_starts,
                           const uint rows,
                           const float first,
                           const float scale,
                           const uint bins,
                           __global const uint* column_of_bin,
                           const uint columns,
                           __global const uint* tile_rows,
                           __global const uint* tile_row_of_row,
                           const uint width,
                           const uint tile_rays,
                           __global uint* used,
                           __global uint* slot_of_ray,
                           __global uint* fullest) {
  const uint row = get_global_id(0);
  if (row >= rows) return;
  __global uint* own = used + (ulong)row * columns;
  for (uint c = 0; c < columns; ++c) own[c] = 0;
  const uint ty = tile_row_of_row[row];
  const uint base = (row - tile_rows[ty]) * width;
  uint most = 0;
  for (uint i = row_starts[row]; i < row_starts[row + 1]; ++i) {
    const uint ray = order[i];
    const uint c = column_of_bin[tiling_bin(x[ray], first, scale, bins)];
    slot_of_ray[ray] = (ty * columns + c) * tile_rays + base + own[c];
    most = max(most, ++own[c]);
  }
  fullest[row] = most;
}

/// Finds the fullest tile of each tile row. One work-item per tile row.
/// in  used[rows][columns] of tiling_slots; tile_rows[tiles + 1]
/// out fullest[tiles]: number of rays
__kernel void tiling_fullest_tiles(__global const uint* used,
                                   __global const uint* tile_rows,
                                   const uint tiles,
                                   const uint columns,
                                   __global uint* fullest) {
  const uint ty = get_global_id(0);
  if (ty >= tiles) return;
  uint most = 0;
  for (uint c = 0; c < columns; ++c) {
    uint rays = 0;
    for (uint row = tile_rows[ty]; row < tile_rows[ty + 1]; ++row) rays += used[(ulong)row * columns + c];
    most = max(most, rays);
  }
  fullest[ty] = most;
}

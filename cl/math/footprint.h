// footprint.h - sensor rows and tiles that a particle's box touches.
// Build: CULLING = 1 drops particles that no requested ray hits, WRAPS = 1 where x is periodic.
#ifndef SIMULI_CL_MATH_FOOTPRINT_H
#define SIMULI_CL_MATH_FOOTPRINT_H
#include "math/extent.h"
#include "shared/layout.h"

/// Number of rows above `elevation` (elevations decrease with the index); `inclusive` also counts rows at it.
FN int beams_above(__global const int* row_lut,
                   __global const real* row_elevation,
                   __global const SensorConstants* sensor,
                   int rows,
                   real elevation,
                   int inclusive) {
  // The table, built from the rows' lowest rays, gives the first candidate; rows of one bin are searched
  // linearly.
  real bin = (elevation - sensor->model.lut_first) * sensor->model.lut_scale;
  bin = bin > R(0.0) ? (bin < R(4095.0) ? bin : R(4095.0)) : R(0.0);
  int row = row_lut[(int)bin];
  while (row < rows && (inclusive ? row_elevation[row] >= elevation : row_elevation[row] > elevation)) ++row;
  return row;
}

// Largest rounding error of x in float; the box test of each ray is decisive.
#define BIN_MARGIN R(5e-6)

/// Tile columns touched by [mean - half, mean + half], as in Footprint; 0 for none. Cameras count pixels whose
/// centres are inside.
FN uint tile_columns(__global const SensorConstants* sensor,
                     __global const uint* column_of_bin,
                     real mean,
                     real half_width) {
#if SENSOR == SENSOR_CAMERA
  const real low = max(ceil(mean - half_width - R(0.5)), sensor->model.first_column);
  const real high = min(floor(mean + half_width - R(0.5)), sensor->model.last_column);
  if (!(low <= high)) return 0;
  const uint first = (uint)low / SIM_BLOCK_SIDE, last = (uint)high / SIM_BLOCK_SIDE;
#else
  const real low = max(mean - half_width - BIN_MARGIN, sensor->model.tile_first);
  const real high = min(mean + half_width + BIN_MARGIN, sensor->model.tile_last);
  if (!(low <= high)) return 0;
  const real x0 = sensor->model.tile_first, scale = sensor->model.tile_scale, bins = sensor->model.tile_bins;
  const uint first = column_of_bin[cell_of(low, x0, scale, bins)] * SIM_TILE_BLOCKS;
  const uint last = column_of_bin[cell_of(high, x0, scale, bins)] * SIM_TILE_BLOCKS + SIM_TILE_BLOCKS - 1;
#endif
  return SIM_COLUMNS(first, last);
}

#if CULLING
/// Occupied cells of the ray mask in mask rows [top, bottom] that [mean - half, mean + half] touches.
FN uint occupied_cells(__global const SensorConstants* sensor,
                       __global const uint* areas,
                       real mean,
                       real half_width,
                       uint top,
                       uint bottom) {
  const real x0 = sensor->model.tile_first, scale = sensor->model.mask_scale,
             columns = sensor->model.mask_columns;
  const real low = max(mean - half_width - BIN_MARGIN, x0);
  const real high = min(mean + half_width + BIN_MARGIN, sensor->model.tile_last);
  if (!(low <= high)) return 0;
  const uint stride = (uint)columns + 1;
  const uint left = cell_of(low, x0, scale, columns), right = cell_of(high, x0, scale, columns) + 1;
  __global const uint* above = areas + top * stride;
  __global const uint* below = areas + (bottom + 1) * stride;
  return (below[right] - above[right]) - (below[left] - above[left]);
}
#endif

/// Joins two touching or overlapping intervals, so that no tile counts twice.
FN void join_columns(Footprint* f) {
  if (f->others == 0) return;
  if (f->columns == 0) {
    f->columns = f->others;
    f->others = 0;
    return;
  }
  const uint a = SIM_FIRST_BLOCK(f->columns), b = SIM_LAST_BLOCK(f->columns);
  const uint c = SIM_FIRST_BLOCK(f->others), d = SIM_LAST_BLOCK(f->others);
  if (c / SIM_TILE_BLOCKS <= b / SIM_TILE_BLOCKS + 1 && a / SIM_TILE_BLOCKS <= d / SIM_TILE_BLOCKS + 1) {
    f->columns = SIM_COLUMNS(min(a, c), max(b, d));
    f->others = 0;
  }
}

/// Lookup tables of footprints, described in the kernel's contract.
typedef struct {
  __global const int* row_lut;
  __global const real* row_elevation;
  __global const uint* tile_row_of_row;
  __global const uint* column_of_bin;
  __global const uint* mask_row_of_row;
  __global const uint* areas;
} Tables;

/// Rows and tiles touched by one particle's box; no tiles if it is invisible. record: its lane of
/// [SIM_RECORD][V].
FN Footprint footprint_of(const FrameParams* frame,
                          __global const SensorConstants* sensor,
                          const Tables* tables,
                          real low_y,
                          real high_y,
                          const real* record) {
  Footprint f = {0, 0, 0, 0};
#if SENSOR == SENSOR_CAMERA
  // Pixel rows whose centres are in the box; comparing before converting keeps huge values defined.
  const real row0 = max(ceil(low_y - R(0.5)), sensor->model.first_row);
  const real row1 = min(floor(high_y - R(0.5)), sensor->model.last_row);
  const int row_first = row0 <= row1 ? (int)row0 : 1;
  const int row_last = row0 <= row1 ? (int)row1 : 0;
#else
  const int rows = (int)frame->rows;
  const int row_first = beams_above(tables->row_lut, tables->row_elevation, sensor, rows, high_y, 0);
  const int row_last = beams_above(tables->row_lut, tables->row_elevation + rows, sensor, rows, low_y, 1) - 1;
#endif
  if (row_first <= row_last) {
    const real half_width = fabs(record[SIM_R_BOX_HALF * V]);
    f.columns = tile_columns(sensor, tables->column_of_bin, record[SIM_R_BOX_MEAN * V], half_width);
#if WRAPS
    f.others = tile_columns(sensor, tables->column_of_bin, record[SIM_R_BOX_OTHER * V], half_width);
    join_columns(&f);
#endif
    f.rows = (uint)row_first | (uint)row_last << 16;
#if SENSOR == SENSOR_CAMERA
    const uint ty0 = (uint)row_first / SIM_TILE_SIDE, ty1 = (uint)row_last / SIM_TILE_SIDE;
#else
    const uint ty0 = tables->tile_row_of_row[row_first], ty1 = tables->tile_row_of_row[row_last];
#endif
    f.tile_rows = ty0 | (ty1 - ty0 + 1) << 16;
#if CULLING
    // Both intervals may contain the same cells: only a non-zero count matters.
    const uint top = tables->mask_row_of_row[row_first], bottom = tables->mask_row_of_row[row_last];
    if (occupied_cells(sensor, tables->areas, record[SIM_R_BOX_MEAN * V], half_width, top, bottom) == 0 &&
        occupied_cells(sensor, tables->areas, record[SIM_R_BOX_OTHER * V], half_width, top, bottom) == 0) {
      f.tile_rows = 0;
    }
#endif
  }
  return f;
}

#endif

// project.cl - particles -> blending record, tile rectangle, range key. Launcher: host/render/project.cpp
#include "math/sh.h"
#include "math/unscented.h"

/// Beams (elevation falling with the index) above `elevation`; with `inclusive` those at it as well.
FN int beams_above(__global const int* row_lut,
                       __global const real* row_elevation,
                       __global const real* sensor,
                       int rows,
                       real elevation,
                       int inclusive) {
  // The table starts the search at most a bin or two early; beams of one bin are walked.
  real bin = (elevation - sensor[SIM_S_LUT_FIRST]) * sensor[SIM_S_LUT_SCALE];
  bin = bin > R(0.0) ? (bin < R(4095.0) ? bin : R(4095.0)) : R(0.0);
  int row = row_lut[(int)bin];
  while (row < rows && (inclusive ? row_elevation[row] >= elevation : row_elevation[row] > elevation)) ++row;
  return row;
}

#if SENSOR == SENSOR_CAMERA
/// Tile column of a pixel column; pictures that wrap go on at `tiles` and at -1.
FN int tile_of_column(int column, int width, int tiles) {
  const int turn = column < 0 ? -1 : column >= width ? 1 : 0;
  return turn * tiles + (column - turn * width) / SIM_SLOT_ROW;
}
#endif

/// V particles per work-item: visibility, box, features, record.
/// in  params[rows][stride]; row_lut[4096], row_elevation[beams]: LiDAR only
/// out records[N][16] of visible particles; footprints[N]; keys[N]: bits of the float range from o_ref,
///     0xffffffff for a culled particle. Parameters that are not numbers, or too far out, cull it.
__kernel void project(const FrameParams frame,
                      __global const real* params,
                      __global const real* sensor,
                      __global const int* row_lut,
                      __global const real* row_elevation,
                      __global real* records,
                      __global Footprint* footprints,
                      __global uint* keys) {
  const uint i = get_global_id(0) * V;
  if (i >= frame.particles) return;
  const uint lanes = min((uint)V, frame.particles - i);

  Gaussian g;
  load_gaussian(params, frame.stride, i, sensor, &g);
  const F logit = LDV(params + SIM_OPACITY * frame.stride + i);
  // ln(sigma / cut), where a logit of -80 is as good as -infinity.
  const F bounded = VMAX(VMIN(logit, (F)R(80.0)), (F)R(-80.0));
  const F qmax = R(-2.0) * (log(R(1.0) + exp_lanes(-bounded)) + log(sensor[SIM_S_ALPHA_CUT]));
  const F reach = sqrt(VMAX(qmax, (F)R(0.0)));
  const F radius = reach * VMAX(g.filtered[0], VMAX(g.filtered[1], g.filtered[2]));
  F centre[3];
  sensor_from_world_point(sensor, g.offset, (F)R(0.5), centre);

  // Positive guards: NaN anywhere makes them false. Beyond these bounds exp, squares and inverses leave the
  // range of floats.
  I visible = AND(qmax > R(0.0), AND(fabs(logit) < R(1e35), radius < R(1e18)));
  visible = AND(visible, AND(g.inv_norm > R(1e-18), g.inv_norm < R(1e18)));
  for (int k = 0; k < 3; ++k) {
    visible = AND(visible, fabs(LDV(params + (SIM_LOG_SCALE + k) * frame.stride + i)) < R(80.0));
  }
  visible = AND(visible, AND(g.range - radius < sensor[SIM_S_T_MAX], g.range > R(1e-6)));
#if SENSOR == SENSOR_CAMERA
  // The ball of that radius against the cone that holds the picture; cone and ball together may reach round
  // to straight behind (sin(cone + ball's half angle) <= 0): then nothing is culled.
  const F step = sqrt(sensor[SIM_S_CENTRE_STEP] * sensor[SIM_S_CENTRE_STEP] +
                      sensor[SIM_S_CENTRE_STEP + 1] * sensor[SIM_S_CENTRE_STEP + 1] +
                      sensor[SIM_S_CENTRE_STEP + 2] * sensor[SIM_S_CENTRE_STEP + 2]);
  const F ball = radius + R(0.5) * step;
  const F tangent2 = fma(g.range, g.range, -(ball * ball));
  const F tangent = sqrt(VMAX(tangent2, (F)R(0.0)));
  const F limit = fma(tangent, (F)sensor[SIM_S_COS_FOV], ball * -sensor[SIM_S_SIN_FOV]);
  const I all_round = fma(tangent, (F)sensor[SIM_S_SIN_FOV], ball * sensor[SIM_S_COS_FOV]) <= R(0.0);
  visible = AND(visible, OR(OR(tangent2 <= R(0.0), all_round), centre[2] >= limit));
#endif
  if (!ANY(visible)) {
    for (uint lane = 0; lane < lanes; ++lane) keys[i + lane] = 0xffffffffu;
    return;
  }

  Box box;
  unscented_box(sensor, &g, reach, &box);
#if SENSOR == SENSOR_CAMERA
  // Some sigma points without an image: the particle may be anywhere in the picture.
  const I known = box.valid;
  box.mean_x = SEL(known, box.mean_x, (F)R(0.0));
  box.mean_y = SEL(known, box.mean_y, (F)R(0.0));
  box.half_x = SEL(known, box.half_x, (F)R(1e9));
  box.half_y = SEL(known, box.half_y, (F)R(1e9));
#if WRAPS
  // Around the camera, or about a pole of the picture, a particle is a band of all columns.
  const F flat = sqrt(centre[0] * centre[0] + centre[2] * centre[2]);
  const I inside = g.range <= radius;
  const I around = OR(inside, flat <= fma(fabs(centre[1]), (F)R(0.05), radius));
  const F ratio = VMIN(radius / g.range, (F)R(1.0));
  const F spread = atan2_lanes(ratio, sqrt(VMAX(fma(-ratio, ratio, (F)R(1.0)), (F)R(0.0))));
  const F pole_y = fma(atan2_lanes(centre[1], flat), (F)sensor[SIM_S_FY], (F)sensor[SIM_S_CY]);
  box.mean_y = SEL(around, pole_y, box.mean_y);
  box.half_y = SEL(around, SEL(inside, (F)R(1e9), spread * sensor[SIM_S_FY]), box.half_y);
  // Nearly all round is all round: per ray the wrapped difference is not formed.
  const real widest = R(0.5) * sensor[SIM_S_PERIOD] - R(0.5) * SIM_SLOT_ROW;
  box.half_x = SEL(OR(around, box.half_x > widest), (F)R(1e9), box.half_x);
#endif
#else
  const F height = centre[2] - sensor[SIM_S_HEIGHT_REF];
  const F flat = sqrt(centre[0] * centre[0] + centre[1] * centre[1]);
  const F distance = sqrt(flat * flat + height * height);
  const I inside = distance <= radius;
  const I around = OR(inside, flat <= fma(fabs(height), (F)R(0.05), radius));
  const F ratio = VMIN(radius / VMAX(distance, (F)R(1e-9)), (F)R(1.0));
  const F spread = atan2_lanes(ratio, sqrt(VMAX(fma(-ratio, ratio, (F)R(1.0)), (F)R(0.0))));
  box.mean_y = SEL(around, atan2_lanes(height, flat), box.mean_y);
  box.half_y = SEL(around, SEL(inside, (F)R(4.0), spread), box.half_y);
#if MOVING
  // Near the cut of the sweep a surface is met from the pose at the start and from that at the end; so are
  // rings, which hold the cut.
  {
    F cut = box.mean_x - sensor[SIM_S_AZIMUTH_FIRST];
    cut = fabs(wrap_lanes(cut, TWO_PI_R));
    F first[3], last[3], x0, y0, x1, y1;
    I seen = visible;
    sensor_from_world_point(sensor, g.offset, (F)R(0.0), first);
    sensor_from_world_point(sensor, g.offset, (F)R(1.0), last);
    project_point(sensor, first, &x0, &y0, &seen);
    project_point(sensor, last, &x1, &y1, &seen);
    const I at_cut = OR(around, cut < box.half_x + R(0.2));
    box.half_x += SEL(at_cut, fabs(wrap_lanes(x1 - x0, TWO_PI_R)), (F)R(0.0));
    box.half_y += SEL(at_cut, fabs(y1 - y0), (F)R(0.0));
  }
#endif
  const F lever = sensor[SIM_S_LEVER] / VMAX(distance - sensor[SIM_S_LEVER], (F)R(1e-3));
  box.half_x += lever;
  box.half_y += lever;
  // Nearly all round is all round: per ray the wrapped difference is not formed.
  box.half_x = SEL(OR(around, box.half_x > PI_R - R(0.2)), (F)R(1e9), box.half_x);
#endif

  BlendMatrix b;
  blend_matrix(&g, &b);
  visible = AND(visible, AND(b.radius2 > R(1e-30), b.radius2 < R(1e30)));

  real out[SIM_RECORD * V];
  for (int k = 0; k < 9; ++k) STV(out + k * V, b.a[k]);
  STV(out + SIM_R_RADIUS2 * V, b.radius2);
  STV(out + SIM_R_QMAX * V, qmax);
  STV(out + SIM_R_BOX_MEAN * V, box.mean_x);
  STV(out + SIM_R_BOX_HALF * V, box.half_x);

  // Tiles and rows, lane by lane: integers from here on.
  real low_x[V], high_x[V], low_y[V], high_y[V], seen[V], range[V];
  STV(low_x, box.mean_x - box.half_x);
  STV(high_x, box.mean_x + box.half_x);
  STV(low_y, box.mean_y - box.half_y);
  STV(high_y, box.mean_y + box.half_y);
  STV(seen, SEL(visible, (F)R(1.0), (F)R(0.0)));
  STV(range, g.range);
  uint drawn = 0;
  for (uint lane = 0; lane < lanes; ++lane) {
    Footprint f = {0, 0, 0, 0};
    uint key = 0xffffffffu;
    if (seen[lane] > R(0.5)) {
#if SENSOR == SENSOR_CAMERA
      // Pixels whose centres lie in the box; comparing before converting keeps huge values defined.
      real column0 = ceil(low_x[lane] - R(0.5));
      real column1 = floor(high_x[lane] - R(0.5));
      const real row0 = max(ceil(low_y[lane] - R(0.5)), R(0.0));
      const real row1 = min(floor(high_y[lane] - R(0.5)), sensor[SIM_S_HEIGHT] - R(1.0));
      const int tiles = (int)frame.tiles_x;
#if WRAPS
      // One column on either side covers the rounding of the wrap; the box itself decides per ray.
      const int all = column1 - column0 + R(3.0) >= sensor[SIM_S_WIDTH];
      column0 = all ? R(0.0) : column0 - R(1.0);
      column1 = all ? sensor[SIM_S_WIDTH] - R(1.0) : column1 + R(1.0);
#else
      column0 = max(column0, R(0.0));
      column1 = min(column1, sensor[SIM_S_WIDTH] - R(1.0));
#endif
      if (column0 <= column1 && row0 <= row1) {
        const int first = tile_of_column((int)column0, (int)sensor[SIM_S_WIDTH], tiles);
        const int last = tile_of_column((int)column1, (int)sensor[SIM_S_WIDTH], tiles);
        f.tile_x = ((first % tiles) + tiles) % tiles;
        f.tile_count = min(last - first + 1, tiles);
        f.row_first = (int)row0;
        f.row_last = (int)row1;
      }
#else
      const int rows = (int)frame.rows;
      f.row_first = beams_above(row_lut, row_elevation, sensor, rows, high_y[lane], 0);
      f.row_last = beams_above(row_lut, row_elevation, sensor, rows, low_y[lane], 1) - 1;
      if (f.row_first <= f.row_last) {
        const int tiles = (int)frame.tiles_x;
        if (high_x[lane] > R(1e8)) {
          f.tile_count = tiles;
        } else {
          // The margin covers the rounding of the boundaries on the host; the box itself decides per ray.
          const real origin = sensor[SIM_S_TILE_X0], scale = sensor[SIM_S_TILE_SCALE];
          const int first = (int)floor((low_x[lane] - origin) * scale - R(1e-3));
          const int last = (int)floor((high_x[lane] - origin) * scale + R(1e-3));
          f.tile_count = min(last - first + 1, tiles);
          f.tile_x = ((first % tiles) + tiles) % tiles;
        }
      }
#endif
      if (f.tile_count > 0) key = as_uint((float)range[lane]);
    }
    keys[i + lane] = key;
    footprints[i + lane] = f;
    drawn |= f.tile_count > 0 ? 1u << lane : 0u;
  }
  if (drawn == 0) return;

  // Features only now: most particles outside the field of view never read their SH.
  const F inv_range = R(1.0) / g.range;
  F basis[SH_COEFFICIENTS];
  sh_basis(g.offset[0] * inv_range, g.offset[1] * inv_range, g.offset[2] * inv_range, basis);
  I usable = (F)R(0.0) == (F)R(0.0);
  for (int channel = 0; channel < 3; ++channel) {
    F sum = (F)R(0.0);
    for (int k = 0; k < SH_COEFFICIENTS; ++k) {
      sum = fma(basis[k], LDV(params + (SIM_SH + 3 * k + channel) * frame.stride + i), sum);
    }
    usable = AND(usable, fabs(sum) < R(1e20));
#if SENSOR == SENSOR_CAMERA
    sum = VMAX(sum + R(0.5), (F)R(0.0));
#else
    if (channel == 0) sum = VMAX(sum + R(0.5), (F)R(0.0));
#endif
    STV(out + (SIM_R_FEATURE + channel) * V, sum);
  }
  STV(seen, SEL(usable, (F)R(1.0), (F)R(0.0)));
  for (uint lane = 0; lane < lanes; ++lane) {
    if (!(drawn >> lane & 1u)) continue;
    if (!(seen[lane] > R(0.5))) {
      keys[i + lane] = 0xffffffffu;
      continue;
    }
    __global real* record = records + (ulong)(i + lane) * SIM_RECORD;
    for (int k = 0; k < SIM_RECORD; ++k) record[k] = out[k * V + lane];
  }
}

// support.cl - how well what each ray shows is known from recorded views. Launcher: host/support/support.cpp
#include "math/elementary.h"
#include "shared/layout.h"

// Reals of a place (of the ray's sensor, of a recorded view, of an actor's box): a 3x3 rotation row-major, then a
// translation, then what each says.
#define PLACE 16
// Reals of a recorded view's grid: first column, columns per unit, first row, rows per unit, columns, rows, where
// its cells begin, its rays per radian over those of the sensor now.
#define GRID 8
// Reals of a cell: nearest and farthest distance (m), ln of the error, ln of the contrast there.
#define CELL 4

#define FAR_M R(1e6)         // where rays that meet nothing end
#define SAME R(0.03)         // of the distance: what lies that far off a cell's is seen there all the same,
#define OTHER R(0.06)        // and that much further it is something else
#define NEAR_ANGLE R(0.1)    // rad: a view that looks along another direction tells less
#define SEEN_ALONE R(1e-3)   // the least that it tells
#define LOOKS R(3.0)         // half of what further looks add
#define APART_M R(0.01)      // half of what it tells when a ray's median and mean distance differ by more
#define LEAST_EXPONENT R(-80.0)

// Neighbours along a slot row that are looked up alike, and which of them is, unless it has no ray.
#define RUN 4
#define TELLING 1

FN int has_ray(__global const real* sensor_ray, uint s, uint slot) {
  return sensor_ray[slot] != R(0.0) || sensor_ray[s + slot] != R(0.0) || sensor_ray[2 * s + slot] != R(0.0);
}

FN F gathered(__global const real* from, const uint* slot) {
  real each[V];
  for (uint lane = 0; lane < V; ++lane) each[lane] = from[slot[lane]];
  return LDV(each);
}

FN void place_point(__global const real* place, const F* p, F* out) {
  for (int k = 0; k < 3; ++k) {
    const F rest = fma(p[2], (F)place[3 * k + 2], (F)place[9 + k]);
    out[k] = fma(p[0], (F)place[3 * k], fma(p[1], (F)place[3 * k + 1], rest));
  }
}

FN void place_vector(__global const real* place, const F* p, F* out) {
  for (int k = 0; k < 3; ++k) {
    out[k] = fma(p[0], (F)place[3 * k], fma(p[1], (F)place[3 * k + 1], p[2] * place[3 * k + 2]));
  }
}

FN F dot_lanes(const F* a, const F* b) { return fma(a[0], b[0], fma(a[1], b[1], a[2] * b[2])); }

/// What views have told of the points so far.
typedef struct {
  F looks;     // how many have them
  F angle;     // the least angle (its chord) between today's ray and one that has them
  F scale;     // the finest look over today's, at most 1
  F weight, error, contrast, edge;  // sums by weight
} Told;

/// Adds what one view tells of the points p along d, `range` off; a view of another state of the world has 0 in
/// place[12].
FN void look(__global const real* place,
             __global const real* grid,
             __global const real* cells,
             I on,
             const F* p,
             const F* d,
             F range,
             Told* told) {
  F y[3], e[3];
  place_point(place, p, y);
  place_vector(place, d, e);
  const F flat2 = fma(y[0], y[0], y[1] * y[1]);
  const F away = VMAX(sqrt(fma(y[2], y[2], flat2)), (F)R(1e-6));
  // Columns along the sides of the square |x| + |y| = 1, from behind by the right to the front: no arctangent.
  const F side = y[1] / VMAX(fabs(y[0]) + fabs(y[1]), (F)R(1e-9));
  const F behind = SEL(y[1] >= R(0.0), R(2.0) - side, -R(2.0) - side);
  const F column = (SEL(y[0] >= R(0.0), side, behind) - grid[0]) * grid[1];
  const F row = (grid[2] - y[2] / VMAX(sqrt(flat2), (F)R(1e-9))) * grid[3];
  I seen = AND(AND(column >= R(0.0), column < grid[4]), AND(row >= R(0.0), row < grid[5]));
  seen = AND(seen, on);
  if (!ANY(seen)) return;
  real at_column[V], at_row[V], lo[V], hi[V], log_error[V], log_contrast[V];
  STV(at_column, SEL(seen, column, (F)R(0.0)));
  STV(at_row, SEL(seen, row, (F)R(0.0)));
  for (int lane = 0; lane < V; ++lane) {
    const uint cell = (uint)grid[6] + (uint)at_row[lane] * (uint)grid[4] + (uint)at_column[lane];
    const REAL_VECTOR(4) c = vload4(cell, cells);
    lo[lane] = c.s0;
    hi[lane] = c.s1;
    log_error[lane] = c.s2;
    log_contrast[lane] = c.s3;
  }
  const F nearest = LDV(lo), farthest = LDV(hi);
  const F gap = VMAX(VMAX(nearest * (R(1.0) - SAME) - away, away - farthest * (R(1.0) + SAME)), (F)R(0.0));
  const F share = VMIN(gap / (away * OTHER), (F)R(1.0));
  const F left = fma(-share, share, (F)R(1.0));
  const F has = SEL(AND(seen, farthest > R(0.0)), left * left, (F)R(0.0));
  const F cosine = dot_lanes(y, e) / (away * place[13]);
  const F angle = sqrt(VMAX(fma(cosine, (F)R(-2.0), (F)R(2.0)), (F)R(0.0)));
  const F scale = VMIN(range * grid[7] / away, (F)R(1.0));
  const F off = angle * (R(1.0) / NEAR_ANGLE);
  const F along = R(1.0) / fma(off, off, (F)R(1.0));
  const F weight = has * fma(along * along, scale, (F)SEEN_ALONE);
  told->looks += has;
  told->angle = SEL(has > R(0.5), VMIN(told->angle, angle), told->angle);
  told->scale = VMAX(told->scale, has * scale);
  told->weight += weight;
  told->error = fma(weight, LDV(log_error), told->error);
  told->contrast = fma(weight, LDV(log_contrast), told->contrast);
  const F depth = (farthest - nearest) / VMAX(farthest, (F)R(1e-6));
  told->edge = fma(weight, depth, told->edge);
}

/// What it says of LiDAR rays whether, and from where, they return: of the logarithm of odds.
FN F return_odds(__global const real* out, uint s, const uint* slot, __global const real* trust) {
  const F logit = VMAX(VMIN(gathered(out + SIM_O_DROP * s, slot), (F)-LEAST_EXPONENT), (F)LEAST_EXPONENT);
  const F drop = R(1.0) / (R(1.0) + exp_lanes(-logit));
  const F opacity = R(1.0) - gathered(out + SIM_O_TRANSMITTANCE * s, slot);
  const I met = opacity > R(0.5);
  const F mean = gathered(out + SIM_O_DISTANCE * s, slot) / SEL(met, opacity, (F)R(1.0));
  const F apart = SEL(met, fabs(gathered(out + SIM_O_MEDIAN * s, slot) - mean), (F)R(0.0));
  const F odds = fma(R(4.0) * drop * (R(1.0) - drop), (F)trust[7], drop * trust[8]);
  return fma(apart / (apart + APART_M), (F)trust[9], odds);
}

/// V runs of RUN slots per work-item. Where a ray's light comes from is looked up in the views that were recorded, for
/// one ray of a run, since cells are no finer; whether a LiDAR's rays return is told of each by itself.
/// in  sensor_ray[7][slots]; out[6|7][slots] as blended; sensor[2][PLACE]: at the frame's start and end, in the
///     scene's axes; boxes[actors][PLACE]: to the actor's axes, half its size behind; views[actors + 1][count][PLACE]:
///     from the scene's axes (of actors: from the actor's) to the view's, 1 behind where it has them at all, then
///     how many times larger they were;
///     grids[count][GRID]; cells; trust[10]: of the logarithm of odds, a constant, by looks, angle, scale, error,
///     contrast, edge, and of LiDARs doubt whether a ray returns, drop, how far median and mean are apart
/// out support[slots]: in [0, 1]
__kernel void support(const FrameParams frame,
                      const uint actors,
                      const uint count,
                      const uint drops,
                      __global const real* sensor_ray,
                      __global const real* out,
                      __global const real* sensor,
                      __global const real* boxes,
                      __global const real* views,
                      __global const real* grids,
                      __global const real* cells,
                      __global const real* trust,
                      __global real* support) {
  const uint begin = get_global_id(0) * V * RUN;
  const uint s = frame.slots;
  if (begin >= s) return;
  uint slot[V];
  for (uint lane = 0; lane < V; ++lane) {
    // The last run again where there are no more.
    const uint run = min(begin + lane * RUN, s - RUN);
    slot[lane] = run + TELLING;
    for (uint k = 0; k < RUN && !has_ray(sensor_ray, s, slot[lane]); ++k) slot[lane] = run + k;
  }
  F ray[3], origin[3], from[3], to[3], d[3], p[3];
  for (int k = 0; k < 3; ++k) {
    ray[k] = gathered(sensor_ray + k * s, slot);
    origin[k] = gathered(sensor_ray + (3 + k) * s, slot);
  }
  const F t = gathered(sensor_ray + 6 * s, slot);
  const I is_one = is_ray(ray[0], ray[1], ray[2]);
  // Within a frame a sensor turns by so little that the straight way between the two is as good as the arc.
  place_vector(sensor, ray, from);
  place_vector(sensor + PLACE, ray, to);
  for (int k = 0; k < 3; ++k) d[k] = fma(t, to[k] - from[k], from[k]);
  const F inv_length = R(1.0) / sqrt(SEL(is_one, dot_lanes(d, d), (F)R(1.0)));
  place_point(sensor, origin, from);
  place_point(sensor + PLACE, origin, to);
  const F opacity = R(1.0) - gathered(out + SIM_O_TRANSMITTANCE * s, slot);
  const I met = opacity > R(0.5);
  const F distance = gathered(out + SIM_O_DISTANCE * s, slot) / SEL(met, opacity, (F)R(1.0));
  const F range = SEL(met, distance, (F)FAR_M);
  for (int k = 0; k < 3; ++k) {
    d[k] *= inv_length;
    p[k] = fma(range, d[k], fma(t, to[k] - from[k], from[k]));
  }

  Told told = {(F)R(0.0), (F)R(2.0), (F)R(0.0), (F)R(0.0), (F)R(0.0), (F)R(0.0), (F)R(0.0)};
  I free = is_one;  // of actors, so far
  for (uint a = 0; a < actors; ++a) {
    __global const real* box = boxes + a * PLACE;
    F q[3], e[3];
    place_point(box, p, q);
    I on = AND(free, met);
    for (int k = 0; k < 3; ++k) on = AND(on, fabs(q[k]) <= box[12 + k]);
    if (!ANY(on)) continue;
    place_vector(box, d, e);
    free = AND(free, NOT(on));
    for (uint v = 0; v < count; ++v) {
      __global const real* place = views + ((a + 1) * count + v) * PLACE;
      if (place[12] > R(0.0)) look(place, grids + v * GRID, cells, on, q, e, range, &told);
    }
  }
  if (ANY(free)) {
    for (uint v = 0; v < count; ++v) look(views + v * PLACE, grids + v * GRID, cells, free, p, d, range, &told);
  }

  const F inv_weight = R(1.0) / VMAX(told.weight, (F)R(1e-9));
  F odds = (F)trust[0];
  odds = fma(told.looks / (told.looks + LOOKS), (F)trust[1], odds);
  odds = fma(told.angle, (F)trust[2], odds);
  odds = fma(told.scale, (F)trust[3], odds);
  odds = fma(told.error * inv_weight, (F)trust[4], odds);
  odds = fma(told.contrast * inv_weight, (F)trust[5], odds);
  odds = fma(told.edge * inv_weight, (F)trust[6], odds);
  const F at_all = R(1.0) - exp_lanes(VMAX(told.looks * R(-4.0), (F)LEAST_EXPONENT));
  const I known = AND(is_one, told.looks > R(0.0));
  for (uint k = 0; k < RUN; ++k) {
    uint own[V];
    for (uint lane = 0; lane < V; ++lane) own[lane] = slot[lane] / RUN * RUN + k;
    // Where views look is alike for neighbours; whether and how surely a LiDAR's ray returns is its own.
    F of_ray = odds;
    if (drops) of_ray += return_odds(out, s, own, trust);
    const F clamped = VMAX(VMIN(of_ray, (F)-LEAST_EXPONENT), (F)LEAST_EXPONENT);
    real each[V];
    STV(each, SEL(known, at_all / (R(1.0) + exp_lanes(-clamped)), (F)R(0.0)));
    for (uint lane = 0; lane < V; ++lane) support[own[lane]] = each[lane];
  }
}

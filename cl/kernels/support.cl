// support.cl - how well recorded views support each ray of a frame. Launcher: host/device/support/support.cpp
#include "math/elementary.h"
#include "shared/layout.h"
#include "shared/support.h"

#define SIM_FAR_M R(1e6)         // end of rays that hit nothing
#define SIM_SAME_DEPTH R(0.03)   // relative distance from a cell's depth within which a point counts as seen
#define SIM_OTHER_DEPTH R(0.06)  // further relative distance from which the cell shows another surface
#define SIM_NEAR_RAD R(0.1)      // angle between viewing directions at which a view's evidence is halved
#define SIM_SEEN_ALONE R(1e-3)   // smallest evidence of a view
#define SIM_APART_M R(0.01)      // difference of median and mean distance at which evidence is halved
#define SIM_LEAST_EXPONENT R(-80.0)

// Of a run of neighbouring rays, rows of SIM_SUPPORT_RUN after each other, the second ray of the middle row
// represents the run, unless it has no ray.
#define SIM_TELLING(rows) ((rows) / 2 * SIM_SUPPORT_RUN + 1)

FN int has_ray(__global const real* sensor_ray, uint s, uint slot) {
  return sensor_ray[slot] != R(0.0) || sensor_ray[s + slot] != R(0.0) || sensor_ray[2 * s + slot] != R(0.0);
}

/// Loads the value of each run's representative slot.
FN F of_runs(__global const real* from, const uint* reporting) {
  real each[V];
  SIM_EACH(lane, V) each[lane] = from[reporting[lane]];
  return LDV(each);
}

FN void turn(__global const real* rotation, const F* v, F* out) {
  SIM_EACH(k, 3) {
    out[k] = fma(v[0], (F)rotation[3 * k], fma(v[1], (F)rotation[3 * k + 1], v[2] * rotation[3 * k + 2]));
  }
}

FN void transform(__global const SupportPose* pose, const F* p, F* out) {
  __global const real* rotation = pose->rotation;
  SIM_EACH(k, 3) {
    const F rest = fma(p[2], (F)rotation[3 * k + 2], (F)pose->translation[k]);
    out[k] = fma(p[0], (F)rotation[3 * k], fma(p[1], (F)rotation[3 * k + 1], rest));
  }
}

FN F dot_lanes(const F* a, const F* b) { return fma(a[0], b[0], fma(a[1], b[1], a[2] * b[2])); }

/// Evidence of the views for the points so far.
typedef struct {
  F looks;         // number of views that saw them
  F angle2;        // smallest angle (squared chord) between the current ray and a view's ray
  F scale;         // finest sampling by a view relative to the current ray, at most 1
  F weight, odds;  // sums of weights and weighted log odds
} Told;

/// Adds the evidence of one view for the points p along d at distance `range`.
FN void look(__global const SupportView* view,
             __global const SupportGrid* grid,
             __global const real* cells,
             I on,
             const F* p,
             const F* d,
             F range,
             Told* reported) {
  F from_view[3], y[3];
  SIM_EACH(k, 3) from_view[k] = p[k] - view->position[k];
  turn(view->rotation, from_view, y);
  const F flat2 = fma(y[0], y[0], y[1] * y[1]);
  const F flat = VMAX(sqrt(flat2), (F)R(1e-9));
  const F away = VMAX(sqrt(fma(y[2], y[2], flat2)), (F)R(1e-6));
  const F around = VMAX(fabs(y[0]) + fabs(y[1]), (F)R(1e-9));
  // 1 - cos of the angle between the current ray and the view's ray, times `away`.
  const F bend = VMAX(fma(dot_lanes(from_view, d), (F)-view->enlargement, away), (F)R(0.0));
  const F near = fma(bend, (F)(R(2.0) / (SIM_NEAR_RAD * SIM_NEAR_RAD)), away);
  const F inv_away = R(1.0) / away, along = away / near;
  // Columns along the sides of the square |x| + |y| = 1, from behind via the right to the front: needs no
  // arctangent.
  const F side = y[1] / around;
  const F behind = SEL(y[1] >= R(0.0), R(2.0) - side, -R(2.0) - side);
  const F column = (SEL(y[0] >= R(0.0), side, behind) - grid->first_column) * grid->columns_per_unit;
  const F row = (grid->first_row - y[2] / flat) * grid->rows_per_unit;
  I seen = AND(AND(column >= R(0.0), column < grid->columns), AND(row >= R(0.0), row < grid->rows));
  seen = AND(seen, on);
  if (!ANY(seen)) return;
  real lo[V], hi[V], of_cell[V];
  int cell[V];
  STV(cell, TO_INTS(SEL(seen, row, (F)R(0.0))) * (int)grid->columns + TO_INTS(SEL(seen, column, (F)R(0.0))));
  SIM_EACH(lane, V) {
    const REAL_VECTOR(4) c = vload4((uint)grid->first_cell + cell[lane], cells);
    lo[lane] = c.s0;
    hi[lane] = c.s1;
    of_cell[lane] = c.s2;
  }
  const F nearest = LDV(lo), farthest = LDV(hi);
  const F gap =
      VMAX(VMAX(nearest * (R(1.0) - SIM_SAME_DEPTH) - away, away - farthest * (R(1.0) + SIM_SAME_DEPTH)),
           (F)R(0.0));
  const F share = VMIN(gap * inv_away * (R(1.0) / SIM_OTHER_DEPTH), (F)R(1.0));
  const F left = fma(-share, share, (F)R(1.0));
  const F has = SEL(AND(seen, farthest > R(0.0)), left * left, (F)R(0.0));
  const F angle2 = R(2.0) * bend * inv_away;
  const F scale = VMIN(range * grid->fineness * inv_away, (F)R(1.0));
  const F weight = has * fma(along * along, scale, (F)SIM_SEEN_ALONE);
  reported->looks += has;
  reported->angle2 = SEL(has > R(0.5), VMIN(reported->angle2, angle2), reported->angle2);
  reported->scale = VMAX(reported->scale, has * scale);
  reported->weight += weight;
  reported->odds = fma(weight, LDV(of_cell), reported->odds);
}

/// Returns the log-odds evidence of V LiDAR rays for whether and where they return. `out`: from the first slot.
FN F return_odds(__global const real* out, uint s, __global const SupportFrame* trust) {
  const F logit = VMAX(VMIN(LDV(out + SIM_O_DROP * s), (F)-SIM_LEAST_EXPONENT), (F)SIM_LEAST_EXPONENT);
  const F drop = R(1.0) / (R(1.0) + exp_lanes(-logit));
  const F opacity = R(1.0) - LDV(out + SIM_O_TRANSMITTANCE * s);
  const I met = opacity > R(0.5);
  const F mean = LDV(out + SIM_O_DISTANCE * s) / SEL(met, opacity, (F)R(1.0));
  const F apart = SEL(met, fabs(LDV(out + SIM_O_MEDIAN * s) - mean), (F)R(0.0));
  const F odds = fma(R(4.0) * drop * (R(1.0) - drop), (F)trust->doubt, drop * trust->drop);
  return fma(apart / (apart + SIM_APART_M), (F)trust->apart, odds);
}

/// Computes support. V runs of `rows` (1, 2 or 4) times SIM_SUPPORT_RUN slots per work-item: neighbours along a
/// beam, or of a pixel block. The views that saw a ray's surface are looked up for one representative ray per
/// run, because cells are no finer; whether a LiDAR ray returns is evaluated for each ray.
/// in  sensor_ray[7][slots]; ray_of_slot[slots], -1: none; out[6|7][slots] as blended; grids[count] of the
///     recorded views; boxes[actors]; views[actors + 1][count], from the scene's axes and from those of each
///     actor; cells[][4]: nearest and farthest distance (m), packed log-odds of error, contrast and depth, 0
/// out support[rays] in [0, 1], for rays with a slot
__kernel void support(const FrameParams frame,
                      const uint actors,
                      const uint count,
                      const uint drops,
                      const uint rows,
                      const uint in_blocks,
                      __global const real* sensor_ray,
                      __global const int* ray_of_slot,
                      __global const real* out,
                      __global const SupportFrame* requested,
                      __global const SupportGrid* grids,
                      __global const SupportBox* boxes,
                      __global const SupportView* views,
                      __global const real* cells,
                      __global real* support) {
  const uint first_run = get_global_id(0) * V;
  const uint s = frame.slots;
  const uint of_run = SIM_SUPPORT_RUN * rows, runs = s / of_run;
  if (first_run >= runs) return;
  F ray[3], origin[3], from[3], to[3], d[3], p[3];
  uint reporting[V];
  SIM_EACH(lane, V) {
    // Repeats the last run beyond the end.
    reporting[lane] = min(first_run + lane, runs - 1) * of_run + SIM_TELLING(rows);
  }
  SIM_EACH(k, 3) ray[k] = of_runs(sensor_ray + k * s, reporting);
  I is_one = is_ray(ray[0], ray[1], ray[2]);
  if (ANY(NOT(is_one))) {
    SIM_EACH(lane, V) {
      const uint run = min(first_run + lane, runs - 1) * of_run;
      for (uint k = 0; k < of_run && !has_ray(sensor_ray, s, reporting[lane]); ++k) reporting[lane] = run + k;
    }
    SIM_EACH(k, 3) ray[k] = of_runs(sensor_ray + k * s, reporting);
    is_one = is_ray(ray[0], ray[1], ray[2]);
  }
  SIM_EACH(k, 3) origin[k] = of_runs(sensor_ray + (3 + k) * s, reporting);
  const F t = of_runs(sensor_ray + 6 * s, reporting);
  const F opacity = R(1.0) - of_runs(out + SIM_O_TRANSMITTANCE * s, reporting);
  const F along = of_runs(out + SIM_O_DISTANCE * s, reporting);
  // A sensor rotates so little within a frame that linear interpolation is as good as the arc.
  turn(requested->start.rotation, ray, from);
  turn(requested->end.rotation, ray, to);
  SIM_EACH(k, 3) d[k] = fma(t, to[k] - from[k], from[k]);
  const F inv_length = R(1.0) / sqrt(SEL(is_one, dot_lanes(d, d), (F)R(1.0)));
  transform(&requested->start, origin, from);
  transform(&requested->end, origin, to);
  const I met = opacity > R(0.5);
  const F range = SEL(met, along / SEL(met, opacity, (F)R(1.0)), (F)SIM_FAR_M);
  SIM_EACH(k, 3) {
    d[k] *= inv_length;
    p[k] = fma(range, d[k], fma(t, to[k] - from[k], from[k]));
  }

  Told reported = {(F)R(0.0), (F)R(4.0), (F)R(0.0), (F)R(0.0), (F)R(0.0)};
  I free = is_one;  // of actors tested so far
  for (uint a = 0; a < actors; ++a) {
    __global const SupportBox* box = boxes + a;
    F q[3], e[3];
    transform(&box->actor_from_scene, p, q);
    I on = AND(free, met);
    SIM_EACH(k, 3) on = AND(on, fabs(q[k]) <= box->half_size[k]);
    if (!ANY(on)) continue;
    turn(box->actor_from_scene.rotation, d, e);
    free = AND(free, NOT(on));
    for (uint v = 0; v < count; ++v) {
      __global const SupportView* view = views + (a + 1) * count + v;
      if (view->there > R(0.0)) look(view, grids + v, cells, on, q, e, range, &reported);
    }
  }
  if (ANY(free)) {
    for (uint v = 0; v < count; ++v) look(views + v, grids + v, cells, free, p, d, range, &reported);
  }

  F odds = fma(reported.odds, R(1.0) / VMAX(reported.weight, (F)R(1e-9)), (F)requested->bias);
  const F angle = sqrt(reported.angle2);
  odds = fma(angle / (angle + SIM_NEAR_RAD), (F)requested->angle, odds);
  odds = fma(reported.scale, (F)requested->scale, odds);
  const F at_all = R(1.0) - exp_lanes(VMAX(reported.looks * R(-4.0), (F)SIM_LEAST_EXPONENT));
  const I known = AND(is_one, reported.looks > R(0.0));
  real odds_of[V], all_of[V];
  STV(odds_of, odds);
  STV(all_of, SEL(known, at_all, (F)R(0.0)));
  const uint begin = first_run * of_run, log2_of_run = 31 - clz(of_run);
  for (uint k = 0; k < of_run; ++k) {
    const uint first = begin + k * V;
    if (first >= s) return;
    real odds_each[V], all_each[V];
    SIM_EACH(lane, V) {
      odds_each[lane] = odds_of[(k * V + lane) >> log2_of_run];
      all_each[lane] = all_of[(k * V + lane) >> log2_of_run];
    }
    // Neighbours share views; whether a LiDAR ray returns is individual.
    F of_ray = LDV(odds_each);
    if (drops) of_ray += return_odds(out + first, s, requested);
    const F clamped = VMAX(VMIN(of_ray, (F)-SIM_LEAST_EXPONENT), (F)SIM_LEAST_EXPONENT);
    const F found = LDV(all_each) / (R(1.0) + exp_lanes(-clamped));
    real each[V];
    STV(each, found);
#if V > SIM_BLOCK_SIDE
    // Pictures have no holes: all slots between the first and the last pixel of a block have rays (checking
    // each costs a tenth of the time).
    if (in_blocks && ray_of_slot[first] >= 0 && ray_of_slot[first + V - 1] >= 0) {
#pragma unroll
      for (uint lane = 0; lane < V; lane += SIM_BLOCK_SIDE)
        vstore4(vload4(0, each + lane), 0, support + ray_of_slot[first + lane]);
      continue;
    }
#endif
    SIM_EACH(lane, V) {
      const int own = ray_of_slot[first + lane];
      if (own >= 0) support[own] = each[lane];
    }
  }
}

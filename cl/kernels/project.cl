// project.cl - particles -> blending record, tile rectangle, range key. Launcher: host/render/frame/project.cpp
#include "math/cluster.h"
#include "math/extent.h"
#include "math/sh.h"
#include "math/unscented.h"

/// Rows (elevation not rising with the index) above `elevation`; with `inclusive` those at it as well.
FN int beams_above(__global const int* row_lut,
                       __global const real* row_elevation,
                       __global const SensorConstants* sensor,
                       int rows,
                       real elevation,
                       int inclusive) {
  // The table, made of the rows' lowest rays, starts the search early; rows of one bin are walked.
  real bin = (elevation - sensor->model.lut_first) * sensor->model.lut_scale;
  bin = bin > R(0.0) ? (bin < R(4095.0) ? bin : R(4095.0)) : R(0.0);
  int row = row_lut[(int)bin];
  while (row < rows && (inclusive ? row_elevation[row] >= elevation : row_elevation[row] > elevation)) ++row;
  return row;
}

// What rounding in float may move a place x by, at most: the box itself decides per ray.
#define BIN_MARGIN R(5e-6)

/// Tile columns that [mean - half, mean + half] touches: first | count << 16, 0 for none. For cameras those of
/// pixels whose centres lie inside.
FN uint tile_columns(__global const SensorConstants* sensor, __global const uint* column_of_bin, real mean, real half_width) {
#if SENSOR == SENSOR_CAMERA
  const real low = max(ceil(mean - half_width - R(0.5)), R(0.0));
  const real high = min(floor(mean + half_width - R(0.5)), sensor->model.picture_width - R(1.0));
  if (!(low <= high)) return 0;
  const uint first = (uint)low / SIM_SLOT_ROW;
  return first | ((uint)high / SIM_SLOT_ROW - first + 1) << 16;
#else
  const real low = max(mean - half_width - BIN_MARGIN, sensor->model.tile_first);
  const real high = min(mean + half_width + BIN_MARGIN, sensor->model.tile_last);
  if (!(low <= high)) return 0;
  const real x0 = sensor->model.tile_first, scale = sensor->model.tile_scale, bins = sensor->model.tile_bins;
  const uint first = column_of_bin[cell_of(low, x0, scale, bins)];
  return first | (column_of_bin[cell_of(high, x0, scale, bins)] - first + 1) << 16;
#endif
}

#if CULLING
/// Occupied cells of the ray mask among its rows [top, bottom] that [mean - half, mean + half] touches.
FN uint occupied_cells(__global const SensorConstants* sensor,
                       __global const uint* areas,
                       real mean,
                       real half_width,
                       uint top,
                       uint bottom) {
  const real x0 = sensor->model.tile_first, scale = sensor->model.mask_scale, columns = sensor->model.mask_columns;
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

/// Makes two intervals that touch or overlap one, so that no tile is counted twice.
FN void join_columns(Footprint* f) {
  if (f->others == 0) return;
  const uint a = SIM_LOW(f->columns), b = a + SIM_HIGH(f->columns);
  const uint c = SIM_LOW(f->others), d = c + SIM_HIGH(f->others);
  if (f->columns == 0) {
    f->columns = f->others;
    f->others = 0;
  } else if (c <= b && a <= d) {
    f->columns = min(a, c) | (max(b, d) - min(a, c)) << 16;
    f->others = 0;
  }
}

/// 2 ln(opacity / least alpha): up to which squared distance in standard deviations a particle counts.
FN F largest_q(__global const SensorConstants* sensor, const Gaussian* g, F logit) {
  // ln(sigma / cut), where a logit of -80 is as good as -infinity.
  const F bounded = VMAX(VMIN(logit, (F)R(80.0)), (F)R(-80.0));
#if COMPENSATION
  Compensation kept;
  compensation(g, &kept);
  return R(2.0) * (kept.log_share - log(R(1.0) + exp_lanes(-bounded)) - log(sensor->alpha_cut));
#else
  return R(-2.0) * (log(R(1.0) + exp_lanes(-bounded)) + log(sensor->alpha_cut));
#endif
}

/// Whether particles may be met at all, `radius` large, carried along by `travel` (m) during the frame. False for
/// what is not a number.
FN I may_be_seen(const FrameParams* frame,
                 __global const SensorConstants* sensor,
                 __global const real* params,
                 uint i,
                 const Gaussian* g,
                 const F* centre,
                 F logit,
                 F qmax,
                 F radius,
                 F travel) {
  // Positive guards: NaN anywhere makes them false. Beyond these bounds exp, squares and inverses leave the
  // range of floats.
  I visible = AND(qmax > R(0.0), AND(fabs(logit) < R(1e35), radius < R(1e18)));
#if ACTORS
  if (g->actor.any) visible = AND(visible, g->actor.there);
#endif
  visible = AND(visible, AND(g->inv_norm > R(1e-18), g->inv_norm < R(1e18)));
  for (int k = 0; k < 3; ++k) {
    visible = AND(visible, fabs(LDV(params + (SIM_LOG_SCALE + k) * frame->stride + i)) < R(80.0));
  }
  const F far = sensor->model.t_max + origin_reach(frame, sensor);
  visible = AND(visible, AND(g->range - radius - R(0.5) * travel < far, g->range > R(1e-6)));
#if SENSOR == SENSOR_CAMERA
  // The ball of that radius against the cone that holds the picture; cone and ball together may reach round
  // to straight behind (sin(cone + ball's half angle) <= 0): then nothing is culled.
  const F step = centre_path(sensor);
  const F ball = radius + R(0.5) * (step + travel);
  const F tangent2 = fma(g->range, g->range, -(ball * ball));
  const F tangent = sqrt(VMAX(tangent2, (F)R(0.0)));
  const F limit = fma(tangent, (F)sensor->cos_view, ball * -sensor->sin_view);
  const I all_round = fma(tangent, (F)sensor->sin_view, ball * sensor->cos_view) <= R(0.0);
  visible = AND(visible, OR(OR(tangent2 <= R(0.0), all_round), centre[2] >= limit));
#endif
  return visible;
}

/// Where particles are on the sensor. Where x goes round, a particle has two places: at the cut of a sweep it is met
/// from the pose at the start and from that at the end (the unrolled spin angle of METHOD section 3).
FN void bounds_of(const FrameParams* frame,
                  __global const SensorConstants* sensor,
                  __global const real* normal_samples,
                  const Gaussian* g,
                  const F* centre,
                  F reach,
                  F radius,
                  I visible,
                  Bounds* box) {
#if EXTENT == EXTENT_EXACT
  exact_bounds(frame, sensor, g, reach, radius, box);
#else
  const I known = unscented_bounds(frame, sensor, normal_samples, g, centre, reach, radius, visible, box);
  if (ANY(AND(visible, NOT(known)))) {
    Bounds all;
    exact_bounds(frame, sensor, g, reach, radius, &all);
    box->mean_x = SEL(known, box->mean_x, all.mean_x);
    box->other_x = SEL(known, box->other_x, all.other_x);
    box->half_x = SEL(known, box->half_x, all.half_x);
    box->low = SEL(known, box->low, all.low);
    box->high = SEL(known, box->high, all.high);
  }
#endif
}

/// What footprints are looked up in (the kernel's contract says what each is).
typedef struct {
  __global const int* row_lut;
  __global const real* row_elevation;
  __global const uint* tile_row_of_row;
  __global const uint* column_of_bin;
  __global const uint* mask_row_of_row;
  __global const uint* areas;
} Tables;

/// Rows and tiles that one particle's box touches; no tiles: nothing sees it. record: its lane of [SIM_RECORD][V].
FN Footprint footprint_of(const FrameParams* frame,
                          __global const SensorConstants* sensor,
                          const Tables* tables,
                          real low_y,
                          real high_y,
                          const real* record) {
  Footprint f = {0, 0, 0, 0};
#if SENSOR == SENSOR_CAMERA
  // Pixel rows whose centres lie in the box; comparing before converting keeps huge values defined.
  const real row0 = max(ceil(low_y - R(0.5)), R(0.0));
  const real row1 = min(floor(high_y - R(0.5)), sensor->model.picture_height - R(1.0));
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
    const uint ty0 = (uint)row_first / SIM_SLOT_ROWS, ty1 = (uint)row_last / SIM_SLOT_ROWS;
#else
    const uint ty0 = tables->tile_row_of_row[row_first], ty1 = tables->tile_row_of_row[row_last];
#endif
    f.tile_rows = ty0 | (ty1 - ty0 + 1) << 16;
#if CULLING
    // Both intervals may hold the same cells: only whether there are any counts.
    const uint top = tables->mask_row_of_row[row_first], bottom = tables->mask_row_of_row[row_last];
    if (occupied_cells(sensor, tables->areas, record[SIM_R_BOX_MEAN * V], half_width, top, bottom) == 0 &&
        occupied_cells(sensor, tables->areas, record[SIM_R_BOX_OTHER * V], half_width, top, bottom) == 0) {
      f.tile_rows = 0;
    }
#endif
  }
  return f;
}

/// All of a record [SIM_RECORD][V] but its features.
FN void put_record(const BlendMatrix* b, const Bounds* box, F qmax, real* out) {
  STV(out, b->a[0]);
  STV(out + V, b->a[1]);
  for (int k = 2; k < 8; ++k) STV(out + k * V, b->a[k + 1]);
  STV(out + SIM_R_RADIUS2 * V, b->radius2);
  STV(out + SIM_R_QMAX * V, qmax);
  STV(out + SIM_R_BOX_MEAN * V, box->mean_x);
  STV(out + SIM_R_BOX_OTHER * V, box->other_x);
  STV(out + SIM_R_BOX_HALF * V, box->half_x);
}

#if ACTOR_MOTION
/// motion[SIM_MOTION][V] of particles of actors, whose records tell it by a box of negative width.
FN void put_motion(const Gaussian* g, const Bounds* box, const F* velocity, F own_time, real* out, real* motion) {
  STV(out + SIM_R_BOX_HALF * V, SEL(g->actor.on, -VMAX(box->half_x, (F)R(1e-30)), box->half_x));
  for (int k = 0; k < 3; ++k) STV(motion + (SIM_M_VELOCITY + k) * V, velocity[k]);
  STV(motion + SIM_M_TIME * V, own_time);
}
#endif

/// One lane of [count][V] to where it stays.
FN void store_lane(const real* lane, __global real* to, int count) {
  for (int k = 0; k < count; ++k) to[k] = lane[k * V];
}

/// Features as they are seen from `towards`, into the lanes of records [SIM_RECORD][V]; false where they are no
/// numbers to blend.
FN I features_of(const FrameParams* frame, __global const real* params, uint i, const F* towards, real* records) {
  F basis[SH_COEFFICIENTS];
  sh_basis(towards[0], towards[1], towards[2], basis);
  I usable = (F)R(0.0) == (F)R(0.0);
  for (int channel = 0; channel < 3; ++channel) {
    F sum = (F)R(0.0);
    for (int k = 0; k < SH_COEFFICIENTS; ++k) {
      sum = fma(basis[k], SH_LANES(params, frame->stride, k, channel, i), sum);
    }
    usable = AND(usable, fabs(sum) < R(1e20));
#if SENSOR == SENSOR_CAMERA
    sum = VMAX(sum + R(0.5), (F)R(0.0));
#else
    if (channel == 0) sum = VMAX(sum + R(0.5), (F)R(0.0));
#endif
    STV(records + (SIM_R_FEATURE + channel) * V, sum);
  }
  return usable;
}

/// V clusters per work-item: which of them the frame may see anything of.
/// in  cluster_bounds[SIM_CLUSTER_ROWS][stride], cluster_actor[stride]; stride 0: nothing is known of them;
///     actors[1 + A] with ACTORS
/// out live[clusters]: 0 where no particle of the cluster can be visible
__kernel void cull_clusters(const FrameParams frame,
                            __global const real* cluster_bounds,
                            __global const uint* cluster_actor,
                            __global const ActorConstants* actors,
                            __global const SensorConstants* sensor,
                            const uint cluster_stride,
                            __global uint* live) {
  const uint clusters = (frame.particles + SIM_CLUSTER - 1) / SIM_CLUSTER;
  const uint i = get_global_id(0) * V;
  if (i >= clusters) return;
  real kept[V];
  STV(kept, (F)R(1.0));
  if (cluster_stride > 0) {
    const I seen = cluster_may_be_seen(&frame, sensor, cluster_bounds, cluster_actor, actors, cluster_stride, i);
    STV(kept, SEL(seen, (F)R(1.0), (F)R(0.0)));
  }
  for (uint lane = 0; lane < V && i + lane < clusters; ++lane) live[i + lane] = kept[lane] > R(0.5) ? 1 : 0;
}

/// V particles per work-item: visibility, box, features, record.
/// in  live[clusters] of cull_clusters; params[rows][stride]; actor_of[stride], actors[1 + A] with ACTORS; deform_offset[3][stride] with DEFORM; LiDAR only:
///     row_lut[4096]; row_elevation[2][rows], lowest and highest of each row's rays; tile_row_of_row[rows];
///     column_of_bin[bins of x]; normal_samples[SIM_MONTE_CARLO][3] with PROJECTION_MONTE_CARLO; with CULLING mask_row_of_row[rows] and areas (ray_mask.cl)
/// out records[N][16] of visible particles; footprints[N]; keys[N]: bits of the float range from o_ref,
///     0xffffffff for a culled particle; motions[N][4] with ACTOR_MOTION. Parameters that are not numbers, or too far out, cull it.
__kernel void project(const FrameParams frame,
                      __global const uint* live,
                      __global const real* params,
                      __global const uint* actor_of,
                      __global const ActorConstants* actors,
                      __global const real* deform_offset,
                      __global const SensorConstants* sensor,
                      __global const int* row_lut,
                      __global const real* row_elevation,
                      __global const uint* tile_row_of_row,
                      __global const uint* column_of_bin,
                      __global const uint* mask_row_of_row,
                      __global const uint* areas,
                      __global const real* normal_samples,
                      __global real* records,
                      __global Footprint* footprints,
                      __global uint* keys,
                      __global real* motions) {
  const uint i = get_global_id(0) * V;
  if (i >= frame.particles) return;
  const uint lanes = min((uint)V, frame.particles - i);
  if (live[i / SIM_CLUSTER] == 0) {
    for (uint lane = 0; lane < lanes; ++lane) keys[i + lane] = 0xffffffffu;
    return;
  }

  call_for_rows(params, frame.stride, SIM_SH, i + V);
  Gaussian g;
  load_gaussian(params, actor_of, actors, deform_offset, frame.stride, i, sensor, &g);
  const F logit = LDV(params + SIM_OPACITY * frame.stride + i);
  const F qmax = largest_q(sensor, &g, logit);
  const F reach = sqrt(VMAX(qmax, (F)R(0.0)));
  const F radius = reach * VMAX(g.filtered[0], VMAX(g.filtered[1], g.filtered[2]));
  F centre[3];
  sensor_from_world_point(sensor, g.offset, (F)R(0.5), centre);

  const F travel = carried(&g, radius);
  I visible = may_be_seen(&frame, sensor, params, i, &g, centre, logit, qmax, radius, travel);
  if (!ANY(visible)) {
    for (uint lane = 0; lane < lanes; ++lane) keys[i + lane] = 0xffffffffu;
    return;
  }

  call_for_sh(params, frame.stride, i);
  Bounds box;
  bounds_of(&frame, sensor, normal_samples, &g, centre, reach, radius, visible, &box);

  F towards[3];
  view_direction(&g, towards);
#if ACTOR_MOTION
  // The record holds for the time at which the middle of the box is seen.
  const F own_time = time_of(sensor, box.mean_x, R(0.5) * (box.low + box.high));
  F velocity[3];
  place_at(&g, own_time, velocity);
#endif
  BlendMatrix b;
  blend_matrix(&g, &b);
  visible = AND(visible, AND(b.radius2 > R(1e-30), b.radius2 < R(1e30)));

  real out[SIM_RECORD * V];
  put_record(&b, &box, qmax, out);
#if ACTOR_MOTION
  real motion[SIM_MOTION * V];
  if (g.actor.any) put_motion(&g, &box, velocity, own_time, out, motion);
#endif

  // Tiles and rows, lane by lane: integers from here on.
  real low_y[V], high_y[V], seen[V], range[V];
  STV(low_y, box.low);
  STV(high_y, box.high);
  STV(seen, SEL(visible, (F)R(1.0), (F)R(0.0)));
  STV(range, g.range);
  const Tables tables = {row_lut, row_elevation, tile_row_of_row, column_of_bin, mask_row_of_row, areas};
  uint drawn = 0;
  for (uint lane = 0; lane < lanes; ++lane) {
    Footprint f = {0, 0, 0, 0};
    uint key = 0xffffffffu;
    if (seen[lane] > R(0.5)) {
      f = footprint_of(&frame, sensor, &tables, low_y[lane], high_y[lane], out + lane);
      if (SIM_TILES(f) > 0) key = as_uint((float)range[lane]);
    }
    keys[i + lane] = key;
    footprints[i + lane] = f;
    drawn |= key != 0xffffffffu ? 1u << lane : 0u;
  }
  if (drawn == 0) return;

  // Features only now: most particles outside the field of view never read their SH.
  const I usable = features_of(&frame, params, i, towards, out);
  STV(seen, SEL(usable, (F)R(1.0), (F)R(0.0)));
  for (uint lane = 0; lane < lanes; ++lane) {
    if (!(drawn >> lane & 1u)) continue;
    if (!(seen[lane] > R(0.5))) {
      keys[i + lane] = 0xffffffffu;
      continue;
    }
    store_lane(out + lane, records + (ulong)(i + lane) * SIM_RECORD, SIM_RECORD);
#if ACTOR_MOTION
    if (g.actor.any) store_lane(motion + lane, motions + (ulong)(i + lane) * SIM_MOTION, SIM_MOTION);
#endif
  }
}

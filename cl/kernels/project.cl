// project.cl - particles -> blending record, tile rectangle, range key. Launcher: host/device/render/frame/project.cpp
#include "math/cluster_culling.h"
#include "math/detail.h"
#include "math/extent.h"
#include "math/footprint.h"
#include "math/sh.h"

/// Returns 2 ln(opacity / alpha cut), the largest squared distance in standard deviations at which a particle
/// contributes.
FN F largest_q(__global const SensorConstants* sensor, const Gaussian* g, F logit, F share) {
  // ln(sigma / cut); a logit of -80 is equivalent to -infinity.
  const F bounded = VMAX(VMIN(logit, (F)R(80.0)), (F)R(-80.0));
  F opaque = log(R(1.0) + exp_lanes(-bounded));
#if DETAIL
  opaque = shared_out(share, bounded, opaque);
#endif
#if ACTORS
  // Scales the opacity; its gradient by the logit does not change.
  if (g->actor.any && ANY(g->actor.there < R(1.0))) opaque -= log(VMAX(g->actor.there, (F)R(1e-30)));
#endif
#if COMPENSATION
  Compensation kept;
  compensation(g, &kept);
  return R(2.0) * (kept.log_share - opaque - log(sensor->alpha_cut));
#else
  return R(-2.0) * (opaque + log(sensor->alpha_cut));
#endif
}

/// Whether rays may hit particles of `radius` that move by `travel` (m) during the frame. False for NaN.
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
  // Guards are positive comparisons, so that NaN fails them. Beyond these bounds exp, squares and inverses
  // overflow floats.
  I visible = AND(qmax > R(0.0), AND(fabs(logit) < R(1e35), radius < R(1e18)));
#if ACTORS
  if (g->actor.any) visible = AND(visible, g->actor.there > R(0.0));
#endif
  visible = AND(visible, AND(g->inv_norm > R(1e-18), g->inv_norm < R(1e18)));
  SIM_EACH(k, 3) {
    visible = AND(visible, fabs(LDV(params + (SIM_LOG_SCALE + k) * frame->stride + i)) < R(80.0));
  }
  const F far = sensor->model.t_max + origin_reach(frame, sensor);
  visible = AND(visible, AND(g->range > R(1e-6), g->range - radius - R(0.5) * travel < far));
#if SENSOR == SENSOR_CAMERA
  // Tests the bounding ball against the cone that contains the picture. Cone and ball together may reach around
  // to straight behind (sin(cone + half angle of the ball) <= 0); then nothing is culled.
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

/// Writes a record [SIM_RECORD][V] except its features.
FN void put_record(const BlendMatrix* b, const Bounds* box, F qmax, real* out) {
  STV(out, b->a[0]);
  STV(out + V, b->a[1]);
#pragma unroll
  for (int k = 2; k < 8; ++k) STV(out + k * V, b->a[k + 1]);
  STV(out + SIM_R_RADIUS2 * V, b->radius2);
  STV(out + SIM_R_QMAX * V, qmax);
  STV(out + SIM_R_BOX_MEAN * V, box->mean_x);
  STV(out + SIM_R_BOX_OTHER * V, box->other_x);
  STV(out + SIM_R_BOX_HALF * V, box->half_x);
}

#if ACTOR_MOTION
/// Writes motion[SIM_MOTION][V] of particles of moving actors, and marks their records by a negative box width.
FN void put_motion(
    const Gaussian* g, const Bounds* box, const F* velocity, F own_time, real* out, real* motion) {
  STV(out + SIM_R_BOX_HALF * V, SEL(g->actor.on, -VMAX(box->half_x, (F)R(1e-30)), box->half_x));
  SIM_EACH(k, 3) STV(motion + (SIM_M_VELOCITY + k) * V, velocity[k]);
  STV(motion + SIM_M_TIME * V, own_time);
}
#endif

/// Copies one lane of [count][V] to its particle.
FN void store_lane(const real* lane, __global real* to, int count) {
  for (int k = 0; k < count; ++k) to[k] = lane[k * V];
}

/// Evaluates features seen from direction `towards` into records [SIM_RECORD][V]; false where they are not
/// finite.
FN I features_of(
    const FrameParams* frame, __global const real* params, uint i, const F* towards, real* records) {
  F basis[SH_COEFFICIENTS];
  sh_basis(towards[0], towards[1], towards[2], basis);
  I usable = (F)R(0.0) == (F)R(0.0);
  SIM_EACH(channel, 3) {
    F sum = (F)R(0.0);
    SIM_EACH(k, SH_COEFFICIENTS) {
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

/// Culls clusters. V clusters per work-item, in frame order.
/// in  cluster_bounds[SIM_CLUSTER_ROWS][stride], cluster_actor[stride]; stride 0: no bounds known; actors[1 +
///     A] with ACTORS
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
    const I seen =
        cluster_may_be_seen(&frame, sensor, cluster_bounds, cluster_actor, actors, cluster_stride, i);
    STV(kept, SEL(seen, (F)R(1.0), (F)R(0.0)));
  }
  for (uint lane = 0; lane < V && i + lane < clusters; ++lane) live[i + lane] = kept[lane] > R(0.5) ? 1 : 0;
}

/// Projects V particles per work-item: visibility, box, features, record. Particles with non-finite or too
/// distant parameters are culled.
/// in  live[clusters] of cull_clusters; with `paged` cluster_at[clusters]: first particle of each cluster in
///     the arrays by particle (otherwise consecutive); params[rows][stride]; actor_of[stride], actors[1 + A]
///     with ACTORS; deform_offset[3][stride] with DEFORM; detail[SIM_DETAIL][stride] with DETAIL
///     LiDAR only: row_lut[4096]; row_elevation[2][rows]: lowest and highest ray of each row;
///         tile_row_of_row[rows]; column_of_bin[bins of x]; normal_samples[SIM_MONTE_CARLO][3] with
///         PROJECTION_MONTE_CARLO; mask_row_of_row[rows] and areas (ray_mask.cl) with CULLING
/// out records[N][16] of visible particles; footprints[N]; keys[N]: bits of the float range from o_ref,
///     0xffffffff for a culled particle; motions[N][4] with ACTOR_MOTION
__kernel void project(const FrameParams frame,
                      const uint paged,
                      __global const uint* live,
                      __global const uint* cluster_at,
                      __global const real* params,
                      __global const uint* actor_of,
                      __global const ActorConstants* actors,
                      __global const real* deform_offset,
                      __global const real* detail,
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
  const uint taken = get_global_id(0) * V;
  if (taken >= frame.particles) return;
  const uint cluster = taken / SIM_CLUSTER;
  const uint i = (paged ? cluster_at[cluster] : cluster) * SIM_CLUSTER + taken % SIM_CLUSTER;
  const uint lanes = min((uint)V, frame.particles - taken);
  if (live[cluster] == 0) {
    for (uint lane = 0; lane < lanes; ++lane) keys[i + lane] = 0xffffffffu;
    return;
  }

  call_for_rows(params, frame.stride, SIM_SH, i + V);
#if DETAIL
  call_for_rows(detail, frame.stride, SIM_DETAIL, i + V);
#endif
  Gaussian g;
  load_place(params, actor_of, actors, deform_offset, frame.stride, i, sensor, &g);
  F share = (F)R(1.0);
#if DETAIL
  share = share_of(sensor, detail + i, frame.stride, g.range);
  if (!ANY(share > R(0.0))) {
    for (uint lane = 0; lane < lanes; ++lane) keys[i + lane] = 0xffffffffu;
    return;
  }
#endif
  load_shape(params, frame.stride, i, sensor, &g);
  const F logit = LDV(params + SIM_OPACITY * frame.stride + i);
  const F qmax = largest_q(sensor, &g, logit, share);
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
#if EXTENT == EXTENT_EXACT
  exact_bounds(&frame, sensor, &g, reach, radius, &box);
#else  // paper/project.cl
  unscented_or_exact_bounds(&frame, sensor, normal_samples, &g, centre, reach, radius, visible, &box);
#endif

  F towards[3];
  view_direction(&g, towards);
#if ACTOR_MOTION
  // The record holds at the time when the sensor sees the middle of the box.
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

  // Tiles and rows, lane by lane, in integers.
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

  // Features come last: most particles outside the field of view never read their SH coefficients.
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

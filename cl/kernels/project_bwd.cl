// project_bwd.cl - gradient slots -> gradients of the parameters. Launcher: host/device/render/backward/project_bwd.cpp
#include "math/gaussian.h"
#include "math/sh.h"

/// Prefetches the inputs of the particles from `next` on, the next of the same work-group.
FN void call_for_next(const FrameParams* frame,
                      __global const real* params,
                      __global const uint* keys,
                      __global const uint* slot_first,
                      __global const real* records,
                      __global const real* grads,
                      uint next) {
  uint any_seen = 0;
  for (uint i = next; i < next + V && i < frame->particles; ++i) {
    if (keys[i] == 0xffffffffu) continue;
    SIM_PREFETCH(grads + (ulong)slot_first[i] * SIM_GRAD);
    SIM_PREFETCH(records + (ulong)i * SIM_RECORD);
    any_seen = 1;
  }
  if (!any_seen) return;
  call_for_rows(params, frame->stride, SIM_SH, next);
  call_for_sh(params, frame->stride, next);
}

/// Sums each particle's gradient slots in order and applies the chain rule of project's record. V particles per
/// work-item. The box and the order carry no gradient (METHOD section 4).
/// in  params[rows][stride]; keys[N], footprints[N], records[N][16] of project; grads[K][16] and slot_first[N]
///     of render_bwd
/// out param_grads[rows][stride]: dL/dparam, 0 for culled particles; with ACTORS pose_grads[6][stride]:
///     dL/d(shift, turn) of the particle's actor at the record's time, without the dependence of the particle's
///     velocity on them
__kernel void project_bwd(const FrameParams frame,
                          __global const real* params,
                          __global const uint* actor_of,
                          __global const ActorConstants* actors,
                          __global const real* deform_offset,
                          __global const SensorConstants* sensor,
                          __global const uint* keys,
                          __global const Footprint* footprints,
                          __global const uint* slot_first,
                          __global const real* records,
                          __global const real* motions,
                          __global const real* grads,
                          __global real* param_grads,
                          __global real* pose_grads) {
  const uint i = get_global_id(0) * V;
  const uint stride = frame.stride;
  if (i >= frame.particles) return;
  const uint lanes = min((uint)V, frame.particles - i);
  call_for_next(&frame, params, keys, slot_first, records, grads, i + V);

  // Slots are rows of 16 reals: adds rows, then transposes the V sums.
  real summed[SIM_GRAD * V];
#if V == 16
  F rows[V];
#endif
  real feature[3 * V];
  real seen[V];
  uint any_seen = 0;
#pragma unroll
  for (uint lane = 0; lane < V; ++lane) {
    REAL_VECTOR(16) sum = (REAL_VECTOR(16))(R(0.0));
    seen[lane] = R(0.0);
    SIM_EACH(c, 3) feature[c * V + lane] = R(0.0);
    if (lane < lanes && keys[i + lane] != 0xffffffffu) {
      const uint count = SIM_TILES(footprints[i + lane]);
      const __global real* slot = grads + (ulong)slot_first[i + lane] * SIM_GRAD;
      for (uint k = 0; k < count; ++k) sum += vload16(k, slot);
      SIM_EACH(c, 3) {
        feature[c * V + lane] = records[(ulong)(i + lane) * SIM_RECORD + SIM_R_FEATURE + c];
      }
      seen[lane] = R(1.0);
      any_seen = 1;
    }
#if V == 16
    rows[lane] = sum;
#else
    real row[SIM_GRAD];
    vstore16(sum, 0, row);
    SIM_EACH(k, SIM_GRAD) summed[k * V + lane] = row[k];
#endif
  }
#if V == 16
  transpose16(rows, summed);
#endif
  if (!any_seen) {
    for (uint row = 0; row < SIM_SH + 3 * SH_COEFFICIENTS; ++row)
      STV(param_grads + row * stride + i, (F)R(0.0));
    return;
  }

  Gaussian g;
  load_gaussian(params, actor_of, actors, deform_offset, stride, i, sensor, &g);
#if ACTOR_MOTION
  const Gaussian half_way = g;
  real time[V];
  SIM_EACH(lane, V) {
    time[lane] =
        g.actor.any && seen[lane] > R(0.5) ? motions[(ulong)(i + lane) * SIM_MOTION + SIM_M_TIME] : R(0.5);
  }
  const F own_time = LDV(time);
  F velocity[3];
  place_at(&g, own_time, velocity);
#endif
  BlendMatrix b;
  blend_matrix(&g, &b);
  const I live = LDV(seen) > R(0.5);

  // Differentiates A = Q M / r and o' = -Q M offset / r with Q constant: any fixed rotation leaves q and tau
  // unchanged.
  F go[3], in[3], gm[9];
  SIM_EACH(k, 3) in[k] = LDV(summed + (SIM_G_ORIGIN + k) * V);
  unreflect(&b, in, go);
  SIM_EACH(c, 3) {
    F column[3];
    SIM_EACH(k, 3) in[k] = LDV(summed + (SIM_G_MATRIX + 3 * k + c) * V);
    unreflect(&b, in, column);
    // o_g = -M offset.
    SIM_EACH(k, 3) gm[3 * k + c] = fma(-go[k], g.offset[c], column[k]);
  }
  F g_mean[3];
  SIM_EACH(c, 3) {
    g_mean[c] = -(b.m[c] * go[0] + b.m[3 + c] * go[1] + b.m[6 + c] * go[2]);
  }
#if ACTOR_MOTION
  // Only the record refers to its own time; filter, compensation and SH refer to mid-frame. From here on, axes
  // are scene axes that rotate with the actor and equal the scene's at mid-frame.
  F turn[9];
  g = half_way;
  if (g.actor.any) {
    actor_turn(&g.actor, own_time, turn);
    const F in_scene[3] = {g_mean[0], g_mean[1], g_mean[2]};
    rotate_back_lanes(turn, in_scene, g_mean);
  }
#endif

  // M = diag(1/s^) R^T; s^ = sqrt(s^2 + kappa range^2).
  F gr[9], g_log_scale[3];
  SIM_EACH(k, 3) {
    const F inv = R(1.0) / g.filtered[k];
    F along = (F)R(0.0);
    SIM_EACH(c, 3) {
      along = fma(gm[3 * k + c], b.m[3 * k + c], along);
      gr[3 * c + k] = gm[3 * k + c] * inv;
    }
    const F g_filtered = -along * inv;
    g_log_scale[k] = g_filtered * g.scale[k] * g.scale[k] * inv;
    const F by_range = g_filtered * inv * sensor->model.kappa;
    SIM_EACH(c, 3) g_mean[c] = fma(by_range, g.offset[c], g_mean[c]);
  }
#if ACTOR_MOTION
  for (int k = 0; k < 3 && g.actor.any; ++k) {
    const F column[3] = {gr[k], gr[3 + k], gr[6 + k]};
    F turned[3];
    rotate_back_lanes(turn, column, turned);
    SIM_EACH(c, 3) gr[3 * c + k] = turned[c];
  }
#endif

#if COMPENSATION
  // The gradient by ln alpha is also the gradient by the logarithm of the share.
  Compensation kept;
  compensation(&g, &kept);
  compensation_gradient(
      &g, &kept, LDV(summed + SIM_G_OPACITY * V), sensor->model.kappa, gr, g_log_scale, g_mean);
#endif
  SIM_EACH(k, 3) {
    STV(param_grads + (SIM_LOG_SCALE + k) * stride + i, SEL(live, g_log_scale[k], (F)R(0.0)));
  }
#if ACTORS
  F g_turn[3];
  if (g.actor.any) {
    // A rotation of the actor rotates the particle's axes ...
    SIM_EACH(k, 3) g_turn[k] = (F)R(0.0);
    SIM_EACH(axis, 3) {
      const F r[3] = {g.rotation[axis], g.rotation[3 + axis], g.rotation[6 + axis]};
      const F gradient[3] = {gr[axis], gr[3 + axis], gr[6 + axis]};
      F torque[3];
      cross_lanes(r, gradient, torque);
      SIM_EACH(k, 3) g_turn[k] += torque[k];
    }
    // ... and R = R_actor R(q).
    F back[9];
    SIM_EACH(axis, 3) {
      const F gradient[3] = {gr[axis], gr[3 + axis], gr[6 + axis]};
      F own[3];
      rotate_back_lanes(g.actor.rotation, gradient, own);
      SIM_EACH(k, 3) back[3 * k + axis] = own[k];
    }
    SIM_EACH(k, 9) gr[k] = back[k];
  }
#endif

  // R(q), then the normalisation of q.
  const F w = g.quaternion[0], x = g.quaternion[1], y = g.quaternion[2], z = g.quaternion[3];
  F gq[4];
  gq[0] = R(2.0) * (x * (gr[7] - gr[5]) + y * (gr[2] - gr[6]) + z * (gr[3] - gr[1]));
  gq[1] = R(2.0) *
          (w * (gr[7] - gr[5]) + y * (gr[1] + gr[3]) + z * (gr[2] + gr[6]) - R(2.0) * x * (gr[4] + gr[8]));
  gq[2] = R(2.0) *
          (w * (gr[2] - gr[6]) + x * (gr[1] + gr[3]) + z * (gr[5] + gr[7]) - R(2.0) * y * (gr[0] + gr[8]));
  gq[3] = R(2.0) *
          (w * (gr[3] - gr[1]) + x * (gr[2] + gr[6]) + y * (gr[5] + gr[7]) - R(2.0) * z * (gr[0] + gr[4]));
  const F radial = gq[0] * w + gq[1] * x + gq[2] * y + gq[3] * z;
  SIM_EACH(k, 4) {
    const F value = (gq[k] - radial * g.quaternion[k]) * g.inv_norm;
    STV(param_grads + (SIM_ROTATION + k) * stride + i, SEL(live, value, (F)R(0.0)));
  }

  // sigma = logistic(logit): d ln sigma / d logit = 1 - sigma.
  const F logit = LDV(params + SIM_OPACITY * stride + i);
  const F one_minus_sigma = R(1.0) / (R(1.0) + exp_lanes(VMAX(VMIN(logit, (F)R(80.0)), (F)R(-80.0))));
  const F g_logit = LDV(summed + SIM_G_OPACITY * V) * one_minus_sigma;
  STV(param_grads + SIM_OPACITY * stride + i, SEL(live, g_logit, (F)R(0.0)));

  // Features; colour and intensity are clamped at 0 from below.
  F basis[SH_COEFFICIENTS];
  F weight[SH_COEFFICIENTS];
  F towards[3];
  view_direction(&g, towards);
  sh_basis(towards[0], towards[1], towards[2], basis);
  SIM_EACH(k, SH_COEFFICIENTS) weight[k] = (F)R(0.0);
  SIM_EACH(channel, 3) {
    F gf = SEL(live, LDV(summed + (SIM_G_FEATURE + channel) * V), (F)R(0.0));
    if (CLAMPED_CHANNELS > channel) gf = SEL(LDV(feature + channel * V) > R(0.0), gf, (F)R(0.0));
    SIM_EACH(k, SH_COEFFICIENTS) {
      const uint row = (SIM_SH + 3 * k + channel) * stride + i;
      weight[k] = fma(gf, LDV(params + row), weight[k]);
      STV(param_grads + row,
          SEL(live, gf * basis[k], (F)R(0.0)));  // the basis of a culled particle may be NaN
    }
  }
#if SH_DEGREE > 0
  const F inv_range = R(1.0) / g.range;
  const F dx = g.offset[0] * inv_range, dy = g.offset[1] * inv_range, dz = g.offset[2] * inv_range;
  F gd[3];
  sh_gradient(towards[0], towards[1], towards[2], weight, gd);
#if ACTORS
  if (g.actor.any) {
    const F direction[3] = {dx, dy, dz};
    const F own[3] = {gd[0], gd[1], gd[2]};
    rotate_lanes(g.actor.rotation, own, gd);
    F torque[3];
    cross_lanes(gd, direction, torque);  // in the actor's frame the direction rotates the other way
    SIM_EACH(k, 3) g_turn[k] += torque[k];
  }
#endif
  const F out = gd[0] * dx + gd[1] * dy + gd[2] * dz;
  g_mean[0] = fma(fma(-out, dx, gd[0]), inv_range, g_mean[0]);
  g_mean[1] = fma(fma(-out, dy, gd[1]), inv_range, g_mean[1]);
  g_mean[2] = fma(fma(-out, dz, gd[2]), inv_range, g_mean[2]);
#endif
#if ACTORS
  if (g.actor.any) {
    F arm[3], shift[3], torque[3];
    SIM_EACH(k, 3) arm[k] = g.offset[k] - g.actor.centre[k];
    cross_lanes(arm, g_mean, torque);
    SIM_EACH(k, 3) g_turn[k] += torque[k], shift[k] = g_mean[k];
#if ACTOR_MOTION
    const F about[3] = {g_turn[0], g_turn[1], g_turn[2]};
    rotate_lanes(turn, g_mean, shift);
    rotate_lanes(turn, about, g_turn);
#endif
    const I counts = AND(live, g.actor.on);
    SIM_EACH(k, 3) {
      STV(pose_grads + (SIM_P_SHIFT + k) * stride + i, SEL(counts, shift[k], (F)R(0.0)));
      STV(pose_grads + (SIM_P_TURN + k) * stride + i, SEL(counts, g_turn[k], (F)R(0.0)));
    }
    const F in_scene[3] = {g_mean[0], g_mean[1], g_mean[2]};
    rotate_back_lanes(g.actor.rotation, in_scene, g_mean);
  }
#endif
  SIM_EACH(c, 3) {
    STV(param_grads + (SIM_MEAN + c) * stride + i, SEL(live, g_mean[c], (F)R(0.0)));
  }
}

// adam.cl - one Adam step on the particles of a frame. Launcher: host/device/render/train/adam.cpp
#include "math/elementary.h"
#include "math/rotation.h"
#include "shared/layout.h"

// Size in m of a particle whose mean moves with the nominal rate; docs/DECISIONS.md, "Learning rates".
#define SIM_MEAN_SIZE R(0.02)

/// Moments and constants common to all rows of a matrix.
typedef struct {
  real beta1, beta2;
  real inv_bias1, inv_bias2;
  __global real* first;
  __global real* second;
} Moments;

/// Updates the moments at index `at` with gradient g; returns the step for rate 1.
FN F step_of(const Moments* moments, uint at, F g, I live, F epsilon) {
  const F m0 = LDV(moments->first + at);
  const F v0 = LDV(moments->second + at);
  const F m = fma((F)moments->beta1, m0, (R(1.0) - moments->beta1) * g);
  const F v = fma((F)moments->beta2, v0, (R(1.0) - moments->beta2) * g * g);
  STV(moments->first + at, SEL(live, m, m0));
  STV(moments->second + at, SEL(live, v, v0));
  return m * moments->inv_bias1 / (sqrt(v * moments->inv_bias2) + epsilon);
}

/// Returns a finite gradient, and 0 for a non-finite one, which is counted in `bad`.
FN F finite_gradient(__global const real* grads, uint i, I live, F* bad) {
  const F raw = LDV(grads + i);
  const I finite = fabs(raw) < R(1e30);
  *bad += SEL(AND(live, !finite), (F)R(1.0), (F)R(0.0));
  return SEL(finite, raw, (F)R(0.0));
}

/// Takes one Adam step. V columns per work-item with all their parameters: particles, or other values with
/// `dense`. Particles culled in the last frame have no gradient: they keep parameters and moments and cost one
/// read of their key.
/// in  keys[particles]: 0xffffffff for a culled particle, unused with `dense`; grads[rows][stride]
///     first: offset of the matrix in params and moments
///     rate[rows], epsilon[rows]: per row; for means the epsilon applies to the gradient times s_k
///     inv_bias1 = 1 / (1 - beta1^t), inv_bias2 = 1 / (1 - beta2^t) (Kingma and Ba, algorithm 1), from the host
/// Means move along the axes of their particle, along axis k by the rate times s_k / sqrt(s SIM_MEAN_SIZE),
/// where s_k is the standard deviation and s the geometric mean of all three. Plain Adam steps have the same
/// length for particles of any size, and the same length across a disk as along it. Moments are those of steps
/// in metres: in units of s_k, which shrinks during training, second moments would outweigh recent gradients.
/// A gradient that is not finite or exceeds 1e30 moves nothing (for a mean no component) and is counted in
/// rejected[0].
__kernel void adam(const uint particles,
                   const uint stride,
                   const uint rows,
                   const uint dense,
                   const uint first,
                   __global const uint* keys,
                   __global const real* rate,
                   __global const real* epsilon,
                   const real beta1,
                   const real beta2,
                   const real inv_bias1,
                   const real inv_bias2,
                   __global const real* grads,
                   __global real* first_moment,
                   __global real* second_moment,
                   __global real* params,
                   __global uint* rejected) {
  const uint column = get_global_id(0) * V;
  if (column >= particles) return;
  real seen[V];
  uint any_seen = 0;
  SIM_EACH(lane, V) {
    const uint live = column + lane < particles && (dense || keys[column + lane] != 0xffffffffu);
    seen[lane] = live ? R(1.0) : R(0.0);
    any_seen |= live;
  }
  if (!any_seen) return;
  const I live = LDV(seen) > R(0.5);
  F bad = (F)R(0.0);
  const Moments moments = {beta1, beta2, inv_bias1, inv_bias2, first_moment, second_moment};
  __global real* mine = params + first + column;
  uint row = SIM_MEAN;
  if (!dense) {
    F gradient[3], own[3], step[3], deviation[3], q[4], axes[9];
    load_rotation(mine, stride, q, axes);
    F size = (F)R(0.0);
    SIM_EACH(k, 3) {
      gradient[k] = finite_gradient(grads, k * stride + column, live, &bad);
      const F log_scale = LDV(mine + (SIM_LOG_SCALE + k) * stride);
      deviation[k] = exp_lanes(log_scale);
      size += log_scale;
    }
    const F share = exp_lanes(R(-0.5) * (size * R(0.33333333333333333) + log(SIM_MEAN_SIZE)));
    rotate_back_lanes(axes, gradient, own);
    const I whole = bad < R(0.5);
    SIM_EACH(k, 3) {
      own[k] = SEL(whole, own[k], (F)R(0.0));
      const F least = epsilon[k] / deviation[k];
      step[k] = rate[k] * share * deviation[k] *
                step_of(&moments, first + k * stride + column, own[k], live, least);
    }
    rotate_lanes(axes, step, own);
    for (; row < SIM_LOG_SCALE; ++row) {
      const F p = LDV(mine + row * stride);
      STV(mine + row * stride, SEL(live, p - own[row], p));
    }
  }
  for (; row < rows; ++row) {
    const uint i = row * stride + column;
    const F g = finite_gradient(grads, i, live, &bad);
    const F step = rate[row] * step_of(&moments, first + i, g, live, (F)epsilon[row]);
    const F p = LDV(params + first + i);
    STV(params + first + i, SEL(live, p - step, p));
  }
  if (ANY(bad > R(0.0))) atomic_add(rejected, (uint)HSUM(bad));
}

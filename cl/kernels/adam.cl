// adam.cl - one Adam step on the particles of a frame. Launcher: host/device/render/train/adam.cpp
#include "math/lanes.h"

/// V columns per work-item, all their parameters: particles, or with `dense` anything. Particles that the last
/// frame culled have no gradient: they keep parameters and moments, and cost one look at their key.
/// in  keys[particles]: 0xffffffff for a culled particle, not read when `dense`; grads[rows][stride]
///     first: where the matrix starts in params and moments
///     rate[rows], epsilon[rows]: of each row; the bias corrections come from the host as
///     inv_bias1 = 1 / (1 - beta1^t) and inv_bias2 = 1 / (1 - beta2^t) (Kingma and Ba, algorithm 1)
/// A gradient that is not finite (or above 1e30) moves nothing and is counted in rejected[0].
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
  for (uint lane = 0; lane < V; ++lane) {
    const uint live = column + lane < particles && (dense || keys[column + lane] != 0xffffffffu);
    seen[lane] = live ? R(1.0) : R(0.0);
    any_seen |= live;
  }
  if (!any_seen) return;
  const I live = LDV(seen) > R(0.5);
  F bad = (F)R(0.0);
  for (uint row = 0; row < rows; ++row) {
    const uint i = row * stride + column;
    const F raw = LDV(grads + i);
    const I finite = fabs(raw) < R(1e30);
    const F g = SEL(finite, raw, (F)R(0.0));
    const uint at = first + i;
    const F m0 = LDV(first_moment + at);
    const F v0 = LDV(second_moment + at);
    const F m = fma((F)beta1, m0, (R(1.0) - beta1) * g);
    const F v = fma((F)beta2, v0, (R(1.0) - beta2) * g * g);
    const F step = rate[row] * (m * inv_bias1) / (sqrt(v * inv_bias2) + epsilon[row]);
    STV(first_moment + at, SEL(live, m, m0));
    STV(second_moment + at, SEL(live, v, v0));
    const F p = LDV(params + at);
    STV(params + at, SEL(live, p - step, p));
    bad += SEL(AND(live, !finite), (F)R(1.0), (F)R(0.0));
  }
  if (ANY(bad > R(0.0))) atomic_add(rejected, (uint)HSUM(bad));
}

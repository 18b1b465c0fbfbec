// adam.cl - one Adam step on a parameter matrix. Launcher: host/render/adam.cpp
#include "math/lanes.h"

/// V elements of one parameter row per work-item; global size (ceil(stride / V), rows).
/// rate[rows]: learning rate of each row, the bias corrections included by the host in
/// `inv_bias1 = 1 / (1 - beta1^t)` and `inv_bias2 = 1 / (1 - beta2^t)` (Kingma and Ba, algorithm 1).
/// A gradient that is not finite (or above 1e30) moves nothing and is counted in rejected[0].
__kernel void adam(const uint stride,
                   __global const real* rate,
                   const real beta1,
                   const real beta2,
                   const real inv_bias1,
                   const real inv_bias2,
                   const real epsilon,
                   __global const real* grads,
                   __global real* first_moment,
                   __global real* second_moment,
                   __global real* params,
                   __global uint* rejected) {
  const uint column = get_global_id(0) * V;
  if (column >= stride) return;
  const uint row = get_global_id(1);
  const uint i = row * stride + column;
  const F raw = LDV(grads + i);
  const I finite = fabs(raw) < R(1e30);
  const F g = SEL(finite, raw, (F)R(0.0));
  const F m = fma((F)beta1, LDV(first_moment + i), (R(1.0) - beta1) * g);
  const F v = fma((F)beta2, LDV(second_moment + i), (R(1.0) - beta2) * g * g);
  STV(first_moment + i, m);
  STV(second_moment + i, v);
  const F step = rate[row] * (m * inv_bias1) / (sqrt(v * inv_bias2) + epsilon);
  STV(params + i, LDV(params + i) - step);
  if (ANY(!finite)) {
    real count = HSUM(SEL(finite, (F)R(0.0), (F)R(1.0)));
    atomic_add(rejected, (uint)count);
  }
}

// regularize.cl - gradients of what a set is asked beside its pictures. Launcher: host/render/train/regularize.cpp
#include "math/elementary.h"
#include "shared/layout.h"

/// V particles per work-item, METHOD section 10: adds the gradients of
///   by_scale (s_1 + s_2 + s_3) + by_opacity sigma + by_entropy (-sigma ln sigma - (1 - sigma) ln(1 - sigma))
/// of every particle. What is added to particles without a gradient is as undefined as what stands there.
__kernel void regularize(const uint particles,
                         const uint stride,
                         const real by_scale,
                         const real by_opacity,
                         const real by_entropy,
                         __global const real* params,
                         __global real* param_grads) {
  const uint i = get_global_id(0) * V;
  if (i >= particles) return;
  for (uint row = SIM_LOG_SCALE; row < SIM_LOG_SCALE + 3; ++row) {
    const F bounded = VMAX(VMIN(LDV(params + row * stride + i), (F)R(80.0)), (F)R(-80.0));
    __global real* gradient = param_grads + row * stride + i;
    STV(gradient, fma((F)by_scale, exp_lanes(bounded), LDV(gradient)));
  }
  const F logit = VMAX(VMIN(LDV(params + SIM_OPACITY * stride + i), (F)R(80.0)), (F)R(-80.0));
  const F e = exp_lanes(-fabs(logit));
  const F slope = e / ((R(1.0) + e) * (R(1.0) + e));  // sigma (1 - sigma)
  __global real* gradient = param_grads + SIM_OPACITY * stride + i;
  // ln((1 - sigma) / sigma) is minus the logit.
  STV(gradient, fma(fma(-by_entropy, logit, (F)by_opacity), slope, LDV(gradient)));
}

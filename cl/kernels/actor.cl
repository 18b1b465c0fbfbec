// actor.cl - sums pose gradients by actor and keeps particles inside their actor's box. Launcher: host/device/render/train/actor.cpp
#include "math/actor.h"
#include "math/lanes.h"

/// Sums pose gradients by actor. One work-item per (actor, chunk of its particles), in the order of the list.
/// in  actor_list[L]: particles, consecutive for each actor; actor_first[A+1]; keys[N]: 0xffffffff for a culled
///     particle; motions[N][4] if `moving`; pose_grads[6][stride]
/// out partial[A][chunks][12]: dL/d(shift, turn) of the actor's pose at the start and at the end of the frame.
///     A pose at the time share t is interpolated with weights (1 - t) and t.
__kernel void actor_pose_sums(const uint actors,
                              const uint chunks,
                              const uint stride,
                              const uint moving,
                              __global const uint* actor_list,
                              __global const uint* actor_first,
                              __global const uint* keys,
                              __global const real* motions,
                              __global const real* pose_grads,
                              __global real* partial) {
  const uint item = get_global_id(0);
  if (item >= actors * chunks) return;
  const uint actor = item / chunks, chunk = item % chunks;
  const uint begin = actor_first[actor], count = actor_first[actor + 1] - begin;
  const uint size = (count + chunks - 1) / chunks;
  const uint from = begin + min(chunk * size, count), to = begin + min((chunk + 1) * size, count);
  real sum[2 * SIM_POSE_GRAD];
  for (int k = 0; k < 2 * SIM_POSE_GRAD; ++k) sum[k] = R(0.0);
  for (uint entry = from; entry < to; ++entry) {
    const uint particle = actor_list[entry];
    if (keys[particle] == 0xffffffffu) continue;
    const real t = moving ? motions[(ulong)particle * SIM_MOTION + SIM_M_TIME] : R(0.5);
    SIM_EACH(k, SIM_POSE_GRAD) {
      const real g = pose_grads[(ulong)k * stride + particle];
      sum[k] = fma(R(1.0) - t, g, sum[k]);
      sum[SIM_POSE_GRAD + k] = fma(t, g, sum[SIM_POSE_GRAD + k]);
    }
  }
  for (int k = 0; k < 2 * SIM_POSE_GRAD; ++k) partial[(ulong)item * 2 * SIM_POSE_GRAD + k] = sum[k];
}

/// Moves particles of actors back into the actor's box and limits their length to a share of it. One work-item
/// per listed particle.
/// in  actor_list[L]; actor_of[N]; bounds[1 + A][4]: half sides of the box (m), largest log-scale
__kernel void actor_confine(const uint count,
                            const uint stride,
                            __global const uint* actor_list,
                            __global const uint* actor_of,
                            __global const real* bounds,
                            __global real* params) {
  const uint entry = get_global_id(0);
  if (entry >= count) return;
  const uint particle = actor_list[entry];
  const __global real* bound = bounds + (ulong)actor_of[particle] * 4;
  SIM_EACH(k, 3) {
    __global real* mean = params + (SIM_MEAN + k) * stride + particle;
    *mean = max(min(*mean, bound[k]), -bound[k]);
    __global real* log_scale = params + (SIM_LOG_SCALE + k) * stride + particle;
    *log_scale = min(*log_scale, bound[3]);
  }
}

// deform_bwd.cl - gradients of deformation grids and of the particles they move. Launcher: host/device/render/backward/deform_bwd.cpp
#include "math/deform.h"

/// Sums node gradients. One work-item per (node of an actor, chunk of the actor's particles), in the order of
/// the list.
/// in  node_actor[nodes]: actor of each node, from 0; node_number[nodes]: index within the actor's grid;
///     actor_list[L], actor_first[A+1]; deform_at[1 + A], deform_shapes as in deform.cl; keys[N]: 0xffffffff
///     for a culled particle; params and param_grads[rows][stride], whose mean rows hold dL/d(deformed
///     position)
/// out partial[nodes][chunks][3]: dL/d(offset)
__kernel void deform_node_sums(const uint nodes,
                               const uint chunks,
                               const uint stride,
                               __global const uint* node_actor,
                               __global const uint* node_number,
                               __global const uint* actor_list,
                               __global const uint* actor_first,
                               __global const uint* deform_at,
                               __global const real* deform_shapes,
                               __global const uint* keys,
                               __global const real* params,
                               __global const real* param_grads,
                               __global real* partial) {
  const uint item = get_global_id(0);
  if (item >= nodes * chunks) return;
  const uint node = item / chunks, chunk = item % chunks;
  const uint actor = node_actor[node], number = node_number[node];
  __global const real* shape = deform_shapes + deform_at[actor + 1];
  const uint begin = actor_first[actor], count = actor_first[actor + 1] - begin;
  const uint size = (count + chunks - 1) / chunks;
  const uint from = begin + min(chunk * size, count), to = begin + min((chunk + 1) * size, count);
  const uint length = (uint)shape[SIM_D_NODES], width = (uint)shape[SIM_D_NODES + 1];
  const real own_x = (real)(number % length), own_y = (real)(number / length % width);
  const real own_z = (real)(number / (length * width));
  real x = R(0.0), y = R(0.0), z = R(0.0);
  for (uint entry = from; entry < to; ++entry) {
    const uint particle = actor_list[entry];
    if (keys[particle] == 0xffffffffu) continue;
    real weight = R(1.0);
    for (int k = 0; k < 3 && weight > R(0.0); ++k) {
      const real at = deform_place(shape, k, params[(ulong)(SIM_MEAN + k) * stride + particle]);
      weight *= max(R(1.0) - fabs(at - (k == 0 ? own_x : k == 1 ? own_y : own_z)), R(0.0));
    }
    if (!(weight > R(0.0))) continue;
    x = fma(weight, param_grads[(ulong)SIM_MEAN * stride + particle], x);
    y = fma(weight, param_grads[(ulong)(SIM_MEAN + 1) * stride + particle], y);
    z = fma(weight, param_grads[(ulong)(SIM_MEAN + 2) * stride + particle], z);
  }
  partial[3 * item] = x;
  partial[3 * item + 1] = y;
  partial[3 * item + 2] = z;
}

/// Adds to a mean's gradient, so far that of the deformed position, the part by which the offset depends on the
/// mean. One particle of an actor per work-item.
/// in  as deform.cl
/// io  param_grads[rows][stride]
__kernel void deform_means(const uint count,
                           const uint stride,
                           __global const uint* actor_list,
                           __global const uint* actor_of,
                           __global const uint* deform_at,
                           __global const real* deform_shapes,
                           __global const uint* keys,
                           __global const real* params,
                           __global real* param_grads) {
  const uint entry = get_global_id(0);
  if (entry >= count) return;
  const uint particle = actor_list[entry];
  const uint at = deform_at[actor_of[particle]];
  if (at == 0xffffffffu || keys[particle] == 0xffffffffu) return;
  __global const real* shape = deform_shapes + at;
  real p[3], gradient[3], by_mean[3];
  SIM_EACH(k, 3) {
    p[k] = params[(ulong)(SIM_MEAN + k) * stride + particle];
    gradient[k] = param_grads[(ulong)(SIM_MEAN + k) * stride + particle];
    by_mean[k] = gradient[k];
  }
  DeformCell cell;
  deform_cell(shape, p, &cell);
  SIM_EACH(corner, 8) {
    __global const real* node = shape + SIM_D_HEADER + 3 * deform_node(&cell, corner);
    const real along = node[0] * gradient[0] + node[1] * gradient[1] + node[2] * gradient[2];
    const real x = deform_share(&cell, corner, 0), y = deform_share(&cell, corner, 1),
               z = deform_share(&cell, corner, 2);
    by_mean[0] = fma((corner & 1u ? along : -along) * cell.slope[0], y * z, by_mean[0]);
    by_mean[1] = fma((corner >> 1 & 1u ? along : -along) * cell.slope[1], x * z, by_mean[1]);
    by_mean[2] = fma((corner >> 2 & 1u ? along : -along) * cell.slope[2], x * y, by_mean[2]);
  }
  SIM_EACH(k, 3) param_grads[(ulong)(SIM_MEAN + k) * stride + particle] = by_mean[k];
}

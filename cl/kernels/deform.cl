// deform.cl - offsets of particles of non-rigid actors. Launcher: host/device/render/frame/deform.cpp
#include "math/deform.h"

/// Interpolates the offset of one actor particle per work-item from its actor's deformation grid.
/// in  actor_list[count]; actor_of[N]; deform_at[1 + A]: index of an actor's grid in deform_shapes, 0xffffffff
///     if rigid; deform_shapes as in deform_cell(); params[rows][stride]
/// out deform_offset[3][stride] of the listed particles, m in the actor's frame; 0 if rigid
__kernel void deform(const uint count,
                     const uint stride,
                     __global const uint* actor_list,
                     __global const uint* actor_of,
                     __global const uint* deform_at,
                     __global const real* deform_shapes,
                     __global const real* params,
                     __global real* deform_offset) {
  const uint entry = get_global_id(0);
  if (entry >= count) return;
  const uint particle = actor_list[entry];
  const uint at = deform_at[actor_of[particle]];
  real offset[3] = {R(0.0), R(0.0), R(0.0)};
  if (at != 0xffffffffu) {
    __global const real* shape = deform_shapes + at;
    real p[3];
    SIM_EACH(k, 3) p[k] = params[(ulong)(SIM_MEAN + k) * stride + particle];
    DeformCell cell;
    deform_cell(shape, p, &cell);
    SIM_EACH(corner, 8) {
      const real weight =
          deform_share(&cell, corner, 0) * deform_share(&cell, corner, 1) * deform_share(&cell, corner, 2);
      __global const real* node = shape + SIM_D_HEADER + 3 * deform_node(&cell, corner);
      SIM_EACH(k, 3) offset[k] = fma(weight, node[k], offset[k]);
    }
  }
  SIM_EACH(k, 3) deform_offset[(ulong)k * stride + particle] = offset[k];
}

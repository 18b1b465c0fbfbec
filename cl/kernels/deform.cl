// deform.cl - how far particles of actors that are not rigid are from where they belong. Launcher: host/device/render/frame/deform.cpp
#include "math/deform.h"

/// One particle of an actor per work-item.
/// in  actor_list[count]; actor_of[N]; deform_at[1 + A]: where in deform_shapes an actor's is, 0xffffffff: it is rigid;
///     deform_shapes as deform_cell() takes them; params[rows][stride]
/// out deform_offset[3][stride] of the particles in the list, m in their actors' frames; 0 where rigid
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

// environment_bwd.cl - gradient of the environment map. Launcher: host/device/render/backward/environment_bwd.cpp
#include "math/environment.h"
#include "shared/layout.h"
#include "shared/sensor_constants.h"

/// Finds the texture cell of each ray. V slots per work-item. Particles need no gradient from here: blending's
/// replay takes the background from the stored features, which contain T x texture.
/// out cell[slots]: texel at the upper left of the ray's direction, width x height for rays that see no
///     texture; slot[slots]: its own index; fraction[2][slots]: weights of the texels to the right and below
__kernel void environment_cells(const FrameParams frame,
                                const uint width,
                                const uint height,
                                __global const SensorConstants* sensor,
                                __global const real* world_ray,
                                __global const real* out,
                                __global uint* cell,
                                __global uint* slot,
                                __global real* fraction) {
  const uint i = get_global_id(0) * V;
  const uint s = frame.slots;
  if (i >= s) return;
  const F dx = LDV(world_ray + i), dy = LDV(world_ray + s + i), dz = LDV(world_ray + 2 * s + i);
  const I open = AND(is_ray(dx, dy, dz), LDV(out + SIM_O_TRANSMITTANCE * s + i) >= sensor->transmittance_cut);
  F x, y;
  environment_place(dx, dy, dz, width, height, &x, &y);
  real px[V], py[V], shows[V];
  STV(px, x);
  STV(py, y);
  STV(shows, SEL(open, (F)R(1.0), (F)R(0.0)));
  SIM_EACH(lane, V) {
    const EnvironmentTexels t = environment_texels(px[lane], py[lane], width, height);
    cell[i + lane] = shows[lane] > R(0.5) ? t.row * width + t.column : width * height;
    slot[i + lane] = i + lane;
    fraction[i + lane] = t.fx;
    fraction[s + i + lane] = t.fy;
  }
}

/// Sum of T x dL/dcolour over the rays of one cell, weighted for its corner (right, below).
FN REAL_VECTOR(4) cell_sum(uint s,
                           uint cell,
                           int right,
                           int below,
                           __global const uint* first,
                           __global const uint* slot,
                           __global const real* fraction,
                           __global const real* out,
                           __global const real* grad_out) {
  REAL_VECTOR(4) sum = (REAL_VECTOR(4))(R(0.0));
  for (uint k = first[cell]; k < first[cell + 1]; ++k) {
    const uint i = slot[k];
    const real fx = fraction[i], fy = fraction[s + i];
    const real weight =
        (right ? fx : R(1.0) - fx) * (below ? fy : R(1.0) - fy) * out[SIM_O_TRANSMITTANCE * s + i];
    const REAL_VECTOR(4) g = (REAL_VECTOR(4))(grad_out[i], grad_out[s + i], grad_out[2 * s + i], R(0.0));
    sum += weight * g;
  }
  return sum;
}

/// Gathers the gradient of one texel per work-item from its four cells in slot order, and adds the gradient of
/// the total variation: tv_scale x the squared differences of neighbours, each divided by its solid angle
/// (horizontally 1 / cos(elevation), vertically cos).
/// in  first[width x height + 2], slot[slots] sorted by cell; grad_out[5][slots] of the features
/// out grads[height][width][4]
__kernel void environment_gather(const FrameParams frame,
                                 const uint width,
                                 const uint height,
                                 const real tv_scale,
                                 __global const uint* first,
                                 __global const uint* slot,
                                 __global const real* fraction,
                                 __global const real* out,
                                 __global const real* grad_out,
                                 __global const real* texture,
                                 __global real* grads) {
  const uint texel = get_global_id(0);
  if (texel >= width * height) return;
  const uint column = texel % width, row = texel / width;
  const uint left = column == 0 ? texel + width - 1 : texel - 1;
  const uint right = column + 1 == width ? texel + 1 - width : texel + 1;
  const uint s = frame.slots;
  REAL_VECTOR(4)
  sum = cell_sum(s, texel, 0, 0, first, slot, fraction, out, grad_out) +
        cell_sum(s, left, 1, 0, first, slot, fraction, out, grad_out);
  if (row > 0) {
    sum += cell_sum(s, texel - width, 0, 1, first, slot, fraction, out, grad_out) +
           cell_sum(s, left - width, 1, 1, first, slot, fraction, out, grad_out);
  }
  const real step = PI_R / (real)height;
  const real elevation = HALF_PI_R - ((real)row + R(0.5)) * step;
  const REAL_VECTOR(4) here = vload4(texel, texture);
  REAL_VECTOR(4) tv = (R(2.0) * here - vload4(left, texture) - vload4(right, texture)) / cos(elevation);
  if (row > 0) tv += (here - vload4(texel - width, texture)) * cos(elevation + R(0.5) * step);
  if (row + 1 < height) tv += (here - vload4(texel + width, texture)) * cos(elevation - R(0.5) * step);
  vstore4(sum + R(2.0) * tv_scale * tv, texel, grads);
}

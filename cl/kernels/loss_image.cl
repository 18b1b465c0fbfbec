// loss_image.cl - colour loss of a rendered picture and its gradient. Launcher: host/device/render/train/loss_image.cpp
#include "math/elementary.h"
#include "math/group.h"
#include "shared/layout.h"

/// LS work-items per tile. With d = rendered - truth, L = sum over pixels and channels of absolute_scale |d| +
/// squared_scale d^2: where a static scene cannot explain the pictures (leaves, passing cars) the first term
/// estimates the median, the second the mean.
/// Pixels with negative truth are unknown and do not count. Where sky_scale > 0, L also has sky_scale max(0, (1
/// - T) - D sky_per_m) for each sky pixel: a particle's weight times its relative nearness to the sky distance,
/// as long as the sum is positive. Without this limit distant particles would always gain by growing, and
/// Adam's steps, which are as large for faint gradients, would grow the far shell until it surrounds the
/// camera.
/// in  out[5][slots] as rendered; picture[3][slots]; truth[3][slots], where sky_scale > 0 [4][slots] with 1 for
///     sky and 0 for other pixels in the last; world_ray[3][slots]: a zero direction marks slots without a
///     pixel
/// out grad_out[5][slots]; sums[tiles][2]: sum of |d| and of d^2
__kernel SIM_GROUP void loss_image(const FrameParams frame,
                                   const real absolute_scale,
                                   const real squared_scale,
                                   const real sky_scale,
                                   const real sky_per_m,
                                   __global const real* world_ray,
                                   __global const real* out,
                                   __global const real* picture,
                                   __global const real* truth,
                                   __global real* grad_out,
                                   __global real* sums) {
  const uint tile = get_global_id(0) / LS, lid = get_global_id(0) % LS;
  const uint s = frame.slots;
  F absolute = (F)R(0.0), squared = (F)R(0.0);
  for (uint j = lid * V; j < frame.tile_rays; j += LS * V) {
    const uint i = tile * frame.tile_rays + j;
    const F x = LDV(world_ray + i), y = LDV(world_ray + s + i), z = LDV(world_ray + 2 * s + i);
    const I real_pixel = AND(is_ray(x, y, z), LDV(truth + i) >= R(0.0));
    SIM_EACH(c, 3) {
      const F difference = SEL(real_pixel, LDV(picture + c * s + i) - LDV(truth + c * s + i), (F)R(0.0));
      absolute += fabs(difference);
      squared = fma(difference, difference, squared);
      F sign = SEL(difference > R(0.0), (F)R(1.0), (F)R(0.0));
      sign = SEL(difference < R(0.0), (F)R(-1.0), sign);
      STV(grad_out + c * s + i, fma(difference, (F)(R(2.0) * squared_scale), sign * absolute_scale));
    }
    F sky_slope = (F)R(0.0);
    if (sky_scale > R(0.0)) {
      const F distance = LDV(out + SIM_O_DISTANCE * s + i), left = LDV(out + SIM_O_TRANSMITTANCE * s + i);
      const I is_near = AND(real_pixel, R(1.0) - left > sky_per_m * distance);
      sky_slope = SEL(is_near, -sky_scale * LDV(truth + 3 * s + i), sky_slope);
    }
    STV(grad_out + SIM_O_TRANSMITTANCE * s + i, sky_slope);
    STV(grad_out + SIM_O_DISTANCE * s + i, sky_per_m * sky_slope);
  }
#if LS > 1
  __local real parts[LS * 2];
  const real own[2] = {HSUM(absolute), HSUM(squared)};
  group_columns(own, 2, parts, sums + 2 * tile);
#else
  sums[2 * tile] = HSUM(absolute);
  sums[2 * tile + 1] = HSUM(squared);
#endif
}

// loss_lidar.cl - distance, intensity and ray-drop losses of a sweep. Launcher: host/render/train/loss_lidar.cpp
#include "math/elementary.h"
#include "shared/layout.h"

#define MIN_OPACITY R(1e-3)

/// One work-item per tile. With O = 1 - T, d^ = (sum of w tau) / O and p = softmax(hit, drop)[drop]:
///   distance:  mean over returned rays of |d^ - d|, where O > 0.001 (elsewhere nothing has a distance)
///   intensity: mean over returned rays of |feature0 - intensity|
///   drop:      mean over all rays of the cross entropy of p
/// scale[3]: weight of each term over its number of rays.
/// in  out[6][slots]; truth[2][slots]: range (m, 0: no return, below 0: not known) and intensity;
///     world_ray: zero marks no ray
/// out grad_out[5][slots]; sums[tiles][4]: |d^ - d|, |intensity error|, cross entropy, wrong decisions
__kernel void loss_lidar(const FrameParams frame,
                         __global const real* scale,
                         __global const real* world_ray,
                         __global const real* out,
                         __global const real* truth,
                         __global real* grad_out,
                         __global real* sums) {
  const uint tile = get_global_id(0);
  const uint s = frame.slots;
  F sum_distance = (F)R(0.0), sum_intensity = (F)R(0.0), sum_entropy = (F)R(0.0), sum_wrong = (F)R(0.0);
  for (uint j = 0; j < frame.tile_rays; j += V) {
    const uint i = tile * frame.tile_rays + j;
    const F x = LDV(world_ray + i), y = LDV(world_ray + s + i), z = LDV(world_ray + 2 * s + i);
    const F range = LDV(truth + i);
    const I fired = AND(is_ray(x, y, z), range >= R(0.0));
    const I returned = AND(fired, range > R(0.0));

    // Intensity.
    const F intensity = SEL(returned, LDV(out + i) - LDV(truth + s + i), (F)R(0.0));
    F sign = SEL(intensity > R(0.0), (F)R(1.0), (F)R(0.0));
    sign = SEL(intensity < R(0.0), (F)R(-1.0), sign);
    STV(grad_out + i, sign * scale[1]);
    sum_intensity += fabs(intensity);

    // Ray drop: cross entropy log(1 + exp(m)), m > 0 when the wrong logit is ahead.
    const F margin = LDV(out + 2 * s + i) - LDV(out + s + i);
    F m = SEL(returned, margin, -margin);
    m = VMAX(VMIN(m, (F)R(60.0)), (F)R(-60.0));
    const F e = exp_lanes(-fabs(m));
    const F wrong = SEL(m > R(0.0), (F)R(1.0), e) / (R(1.0) + e);
    const F entropy = VMAX(m, (F)R(0.0)) + log(R(1.0) + e);
    sum_entropy += SEL(fired, entropy, (F)R(0.0));
    sum_wrong += SEL(AND(fired, m > R(0.0)), (F)R(1.0), (F)R(0.0));
    F g_drop = SEL(returned, wrong, -wrong) * scale[2];
    g_drop = SEL(fired, g_drop, (F)R(0.0));
    STV(grad_out + s + i, -g_drop);
    STV(grad_out + 2 * s + i, g_drop);

    // Distance.
    const F t = LDV(out + SIM_O_TRANSMITTANCE * s + i);
    const F opacity = R(1.0) - t;
    const I placed = AND(returned, opacity > MIN_OPACITY);
    const F inv_opacity = R(1.0) / SEL(placed, opacity, (F)R(1.0));
    const F distance = LDV(out + SIM_O_DISTANCE * s + i) * inv_opacity;
    const F error = SEL(placed, distance - range, (F)R(0.0));
    sign = SEL(error > R(0.0), (F)R(1.0), (F)R(0.0));
    sign = SEL(error < R(0.0), (F)R(-1.0), sign) * scale[0];
    STV(grad_out + SIM_O_DISTANCE * s + i, sign * inv_opacity);
    STV(grad_out + SIM_O_TRANSMITTANCE * s + i, sign * distance * inv_opacity);
    sum_distance += fabs(error);
  }
  sums[4 * tile] = HSUM(sum_distance);
  sums[4 * tile + 1] = HSUM(sum_intensity);
  sums[4 * tile + 2] = HSUM(sum_entropy);
  sums[4 * tile + 3] = HSUM(sum_wrong);
}

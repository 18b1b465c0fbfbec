// loss_lidar.cl - distance, intensity and ray-drop losses of a sweep. Launcher: host/device/render/train/loss_lidar.cpp
#include "math/group.h"
#include "math/ray_drop.h"
#include "shared/layout.h"

#define SIM_MIN_OPACITY R(1e-3)
// Distance at which a returned ray's weight is 1, and below which the weight stops growing.
#define SIM_WEIGHS_ONE_M R(10.0)
#define SIM_WEIGHS_MOST_M R(1.0)
#define SIM_DROP_PARAMETERS (sizeof(DropConstants) / sizeof(real))

// GPUs keep a ray's sums in registers, which cannot be indexed.
#if LS > 1
#define SIM_EACH_SUM _Pragma("unroll")
#else
#define SIM_EACH_SUM
#endif

/// Sums of dL/d(parameters of the ray-drop function) over the rays of a tile, in parameter order.
typedef struct {
  F skip[SIM_DROP_INPUTS];
  F bias;
  F hidden[SIM_DROP_HIDDEN * (SIM_DROP_INPUTS + 1)];
  F out[SIM_DROP_HIDDEN];
} DropSums;

/// Adds the parameter gradients for slope = dL/d(logit) at the inputs x.
/// out by_margin, by_transmittance: d(logit) / d(drop logit minus hit logit), d(logit) / dT
FN void drop_backward(
    __global const DropConstants* f, const F* x, F slope, DropSums* sums, F* by_margin, F* by_transmittance) {
  F d0 = (F)f->skip[0], d1 = (F)f->skip[1];
  for (int j = 0; j < SIM_DROP_INPUTS; ++j) sums->skip[j] = fma(slope, x[j], sums->skip[j]);
  sums->bias += slope;
  SIM_EACH_SUM
  for (int k = 0; k < SIM_DROP_HIDDEN; ++k) {
    F bend;
    sums->out[k] = fma(slope, drop_hidden(f, k, x, &bend), sums->out[k]);
    const int first = k * (SIM_DROP_INPUTS + 1);
    const F by_sum = bend * f->out[k];
    const F g = slope * by_sum;
    for (int j = 0; j < SIM_DROP_INPUTS; ++j) sums->hidden[first + j] = fma(g, x[j], sums->hidden[first + j]);
    sums->hidden[first + SIM_DROP_INPUTS] += g;
    d0 = fma(by_sum, (F)f->hidden[first], d0);
    d1 = fma(by_sum, (F)f->hidden[first + 1], d1);
  }
  *by_margin = d0;
  *by_transmittance = DROP_SCALE * d1;
}

/// LS work-items per tile. With O = 1 - T, d^ = (sum of w tau) / O, and p the probability of the ray-drop
/// function:
///   distance:  mean over returned rays of |d^ - d| sqrt(10 m / max(d, 1 m)), where O > 0.001
///   intensity: mean over returned rays of |feature0 - intensity|
///   drop:      mean over all rays of the cross entropy of p
/// scale[4]: weight of each term divided by its number of rays; for drops separately for the particles and for
/// the function's parameters.
/// in  out[7][slots]; truth[2][slots]: range (m, 0: no return, below 0: unknown) and intensity; world_ray: a
///     zero direction marks slots without a ray
/// out grad_out[5][slots]; sums[tiles][4 + SIM_DROP_PARAMETERS]: distance, |intensity error|, cross entropy,
///     wrong decisions, dL/d(parameters of the ray-drop function)
__kernel SIM_GROUP void loss_lidar(const FrameParams frame,
                                   __global const SensorConstants* sensor,
                                   __global const real* scale,
                                   __global const real* world_ray,
                                   __global const real* out,
                                   __global const real* truth,
                                   __global real* grad_out,
                                   __global real* sums) {
  const uint tile = get_global_id(0) / LS, lid = get_global_id(0) % LS;
  const uint s = frame.slots;
  DropSums drops;
  SIM_EACH_SUM
  for (uint k = 0; k < SIM_DROP_PARAMETERS; ++k) ((F*)&drops)[k] = (F)R(0.0);
  F sum_distance = (F)R(0.0), sum_intensity = (F)R(0.0), sum_entropy = (F)R(0.0), sum_wrong = (F)R(0.0);
  for (uint j = lid * V; j < frame.tile_rays; j += LS * V) {
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

    // Ray drop: cross entropy log(1 + exp(m)), where m > 0 means a wrong decision.
    const F t = LDV(out + SIM_O_TRANSMITTANCE * s + i);
    const F distance_sum = LDV(out + SIM_O_DISTANCE * s + i);
    F met[SIM_DROP_INPUTS];
    drop_inputs(LDV(out + i), LDV(out + s + i), LDV(out + 2 * s + i), t, distance_sum, met);
    const F logit = drop_logit(&sensor->drop, met);
    F m = SEL(returned, logit, -logit);
    m = VMAX(VMIN(m, (F)R(60.0)), (F)R(-60.0));
    const F e = exp_lanes(-fabs(m));
    const F wrong = SEL(m > R(0.0), (F)R(1.0), e) / (R(1.0) + e);
    const F entropy = VMAX(m, (F)R(0.0)) + log(R(1.0) + e);
    sum_entropy += SEL(fired, entropy, (F)R(0.0));
    sum_wrong += SEL(AND(fired, m > R(0.0)), (F)R(1.0), (F)R(0.0));
    const F slope = SEL(fired, SEL(returned, wrong, -wrong), (F)R(0.0));
    F by_margin, by_transmittance;
    drop_backward(&sensor->drop, met, slope * scale[3], &drops, &by_margin, &by_transmittance);
    const F g_drop = slope * scale[2] * by_margin;
    STV(grad_out + s + i, -g_drop);
    STV(grad_out + 2 * s + i, g_drop);

    // Distance.
    const F opacity = R(1.0) - t;
    const I placed = AND(returned, opacity > SIM_MIN_OPACITY);
    const F inv_opacity = R(1.0) / SEL(placed, opacity, (F)R(1.0));
    const F distance = distance_sum * inv_opacity;
    const F error = SEL(placed, distance - range, (F)R(0.0));
    // Equal weights per metre would neglect thin near objects, such as a leaf hit by two rays in five, against
    // the background.
    const F weight = sqrt(SIM_WEIGHS_ONE_M / VMAX(range, (F)SIM_WEIGHS_MOST_M));
    sign = SEL(error > R(0.0), weight, (F)R(0.0));
    sign = SEL(error < R(0.0), -weight, sign) * scale[0];
    STV(grad_out + SIM_O_DISTANCE * s + i, sign * inv_opacity);
    STV(grad_out + SIM_O_TRANSMITTANCE * s + i,
        fma(slope * scale[2], by_transmittance, sign * distance * inv_opacity));
    sum_distance = fma(weight, fabs(error), sum_distance);
  }
  __global real* of_tile = sums + tile * (4 + SIM_DROP_PARAMETERS);
  const F* all = (const F*)&drops;
#if LS > 1
  __local real parts[LS * (4 + SIM_DROP_PARAMETERS)];
  real own[4 + SIM_DROP_PARAMETERS] = {
      HSUM(sum_distance), HSUM(sum_intensity), HSUM(sum_entropy), HSUM(sum_wrong)};
  SIM_EACH_SUM
  for (uint k = 0; k < SIM_DROP_PARAMETERS; ++k) own[4 + k] = HSUM(all[k]);
  group_columns(own, 4 + SIM_DROP_PARAMETERS, parts, of_tile);
#else
  of_tile[0] = HSUM(sum_distance);
  of_tile[1] = HSUM(sum_intensity);
  of_tile[2] = HSUM(sum_entropy);
  of_tile[3] = HSUM(sum_wrong);
  for (uint k = 0; k < SIM_DROP_PARAMETERS; ++k) of_tile[4 + k] = HSUM(all[k]);
#endif
}

// light_bwd.h - replays blending for rays in their own order, in place of light.h: stores the weight of each
// response and the gradient of its ln alpha.
#ifndef SIMULI_CL_MATH_LIGHT_BWD_H
#define SIMULI_CL_MATH_LIGHT_BWD_H
#include "math/blend_bwd.h"
#include "math/met.h"

/// Replay state of V rays with known final outputs.
typedef struct {
  F transmittance;
  F behind;  // g . (remaining features, distance and final transmittance)
  F g[3], g_distance;
  I going;
  __global real* replayed;  // from the list's first entry and the vector's first ray
} Light;

/// out, grad_out: as in render_bwd(), from the vector's first slot on.
FN void start_light(const RayLanes* ray,
                    __global const real* out,
                    __global const real* grad_out,
                    uint slots,
                    __global real* replayed,
                    Light* light) {
  light->transmittance = (F)R(1.0);
  light->replayed = replayed;
  light->going = is_ray(ray->d[0], ray->d[1], ray->d[2]);
  SIM_EACH(c, 3) light->g[c] = LDV(grad_out + (ulong)c * slots);
  light->g_distance = LDV(grad_out + SIM_O_DISTANCE * slots);
  light->behind = behind_of(out, grad_out, slots);
}

/// Zeroes the entry of a list position, until a ray blends it.
FN void clear_place(uint place, __global real* replayed) {
  STV(replayed + (ulong)place * SIM_REPLAYED, (F)R(0.0));
  STV(replayed + (ulong)place * SIM_REPLAYED + SIM_WALK_RAYS, (F)R(0.0));
}

FN void blend(const Met* met, real t_cut, Light* light) {
  const F before = light->transmittance;
  I blends = AND(light->going, met->alpha > R(0.0));
  const F alpha = SEL(blends, met->alpha, (F)R(0.0));
  const F weight = alpha * before;
  F value = light->g[0] * met->feature[0];
  value = fma(light->g[1], met->feature[1], value);
  value = fma(light->g[2], met->feature[2], value);
  value = fma(light->g_distance, met->tau, value);
  const F d_log = log_alpha_gradient(blends, alpha, weight, before, value, &light->behind);
  light->transmittance = before - weight;
  light->going = AND(light->going, light->transmittance >= t_cut);
  // Rays of a vector usually have the same particle as nearest response.
  while (ANY(blends)) {
    const real place = HMAX(SEL(blends, met->place, (F)R(-1.0)));
    const I here = AND(blends, met->place == place);
    __global real* weights = light->replayed + (ulong)place * SIM_REPLAYED;
    STV(weights, SEL(here, weight, LDV(weights)));
    STV(weights + SIM_WALK_RAYS, SEL(here, d_log, LDV(weights + SIM_WALK_RAYS)));
    blends = AND(blends, NOT(here));
  }
}

#endif

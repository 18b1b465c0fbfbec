// light.h - blending for rays in their own order. light_bwd.h is its counterpart in the backward pass.
#ifndef SIMULI_CL_MATH_LIGHT_H
#define SIMULI_CL_MATH_LIGHT_H
#include "math/met.h"
#include "math/ray_drop.h"

/// Accumulated outputs of V rays.
typedef struct {
  F transmittance, distance, median;
  F sum[3];
  F last;  // m, tau of the last blended response
  I going;
} Light;

FN void start_light(const RayLanes* ray, Light* light) {
  light->transmittance = (F)R(1.0);
  light->distance = light->median = light->last = (F)R(0.0);
  SIM_EACH(c, 3) light->sum[c] = (F)R(0.0);
  light->going = is_ray(ray->d[0], ray->d[1], ray->d[2]);
}

FN void blend(const Met* met, real t_cut, Light* light) {
  const F before = light->transmittance;
  const F weight = SEL(light->going, met->alpha, (F)R(0.0)) * before;
#if !ACTOR_IDS
  SIM_EACH(c, 3) light->sum[c] = fma(weight, met->feature[c], light->sum[c]);
#endif
  light->distance = fma(weight, met->tau, light->distance);
  const F left = before - weight;
#if MEDIAN
  const I is_half = AND(before > R(0.5), left <= R(0.5));
#if ACTOR_IDS
  light->sum[0] = SEL(is_half, met->tau, light->sum[0]);
  light->median = SEL(is_half, met->feature[0], light->median);
#else
  light->median = SEL(is_half, met->tau, light->median);
#endif
#endif
  light->last = SEL(light->going, met->tau, light->last);
  light->transmittance = left;
  light->going = AND(light->going, left >= t_cut);
}

/// Writes the outputs of render() from `slot` on.
FN void write_light(Light* light, __global const SensorConstants* sensor, uint slots, __global real* slot) {
  const F t = light->transmittance;
  SIM_EACH(c, 3) {
    light->sum[c] = fma(t, (F)sensor->background[c], light->sum[c]);
    STV(slot + (ulong)c * slots, light->sum[c]);
  }
  STV(slot + SIM_O_TRANSMITTANCE * slots, t);
  STV(slot + SIM_O_DISTANCE * slots, light->distance);
#if MEDIAN
  STV(slot + SIM_O_MEDIAN * slots, light->median);
#endif
#if DROP
  STV(slot + SIM_O_DROP * slots,
      drop_of(&sensor->drop, light->sum[0], light->sum[1], light->sum[2], t, light->distance));
#endif
}

#endif

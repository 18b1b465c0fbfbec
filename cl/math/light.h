// light.h - what rays that order their responses themselves meet and blend: the two kernels of render_window.cl
// share it, so that they round alike.
#ifndef SIMULI_CL_MATH_LIGHT_H
#define SIMULI_CL_MATH_LIGHT_H
#include "math/ray_drop.h"
#include "math/ray_feature.h"
#include "math/response.h"

/// What one particle is to the V rays of a vector. A ray that does not meet it has alpha 0, and the tau of
/// the entry before: it stands where it blends nothing and passes nothing.
typedef struct {
  F tau;  // m
  F alpha;
  F feature[3];
} Met;

/// Takes `met` past `before` in the lanes where it is nearer: the farther of the two goes to `place`, `met` is what
/// goes on.
FN void pass_by(I nearer, const Met* before, Met* place, Met* met) {
  const Met was = *met;
  place->tau = SEL(nearer, before->tau, was.tau);
  met->tau = SEL(nearer, was.tau, before->tau);
  place->alpha = SEL(nearer, before->alpha, was.alpha);
  met->alpha = SEL(nearer, was.alpha, before->alpha);
  for (int c = 0; c < 3; ++c) {
    place->feature[c] = SEL(nearer, before->feature[c], was.feature[c]);
    met->feature[c] = SEL(nearer, was.feature[c], before->feature[c]);
  }
}

/// Through pointers, member by member: see load_ray().
FN void copy_met(const Met* from, Met* to) {
  to->tau = from->tau;
  to->alpha = from->alpha;
  for (int c = 0; c < 3; ++c) to->feature[c] = from->feature[c];
}

/// Sets the feature of what rays along d meet; params, actor_of and actors as ray_feature().
FN void set_feature(Met* met,
                    __global const real* params,
                    uint stride,
                    uint particle,
                    __global const uint* actor_of,
                    __global const ActorConstants* actors,
                    const real* record,
                    const F* d) {
#if RAY_SH
  ray_feature(params, stride, particle, actor_of, actors, d, met->feature);
#else
  for (int c = 0; c < 3; ++c) met->feature[c] = (F)record[SIM_R_FEATURE + c];
#endif
}

/// What V rays have blended so far.
typedef struct {
  F transmittance, distance, median;
  F sum[3];
  F last;   // m, tau of what was blended last
  I going;
} Light;

FN void start_light(const RayLanes* ray, Light* light) {
  light->transmittance = (F)R(1.0);
  light->distance = light->median = light->last = (F)R(0.0);
  for (int c = 0; c < 3; ++c) light->sum[c] = (F)R(0.0);
  light->going = is_ray(ray->d[0], ray->d[1], ray->d[2]);
}

FN void blend(const Met* met, real t_cut, Light* light) {
  const F before = light->transmittance;
  const F weight = SEL(light->going, met->alpha, (F)R(0.0)) * before;
  for (int c = 0; c < 3; ++c) light->sum[c] = fma(weight, met->feature[c], light->sum[c]);
  light->distance = fma(weight, met->tau, light->distance);
  const F left = before - weight;
#if MEDIAN
  light->median = SEL(AND(before > R(0.5), left <= R(0.5)), met->tau, light->median);
#endif
  light->last = SEL(light->going, met->tau, light->last);
  light->transmittance = left;
  light->going = AND(light->going, left >= t_cut);
}

/// Writes the outputs of render() to slots from `slot` on.
FN void write_light(Light* light, __global const SensorConstants* sensor, uint slots, __global real* slot) {
  const F t = light->transmittance;
  for (int c = 0; c < 3; ++c) {
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

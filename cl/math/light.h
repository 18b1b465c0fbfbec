// light.h - what rays that order their responses themselves meet and blend: the kernels of render_window.cl
// share it, forward and backward, so that they round alike.
// Build: REPLAY = 1 to tell, of each response that is blended, its weight and the gradient of its ln alpha.
#ifndef SIMULI_CL_MATH_LIGHT_H
#define SIMULI_CL_MATH_LIGHT_H
#include "math/blend_bwd.h"
#include "math/ray_drop.h"
#include "math/ray_feature.h"
#include "math/response.h"

#ifndef REPLAY
#define REPLAY 0
#endif

/// What one particle is to the V rays of a vector. A ray that does not meet it has alpha 0, and the tau of
/// the entry before: it stands where it blends nothing and passes nothing.
typedef struct {
  F tau;  // m
  F alpha;
  F feature[3];
#if REPLAY
  F place;  // of the particle in the tile's list
#endif
} Met;

/// Takes `met` past `before` in the lanes where it is nearer: the farther of the two goes to `place`, `met`
/// is what goes on.
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
#if REPLAY
  place->place = SEL(nearer, before->place, was.place);
  met->place = SEL(nearer, was.place, before->place);
#endif
}

/// Through pointers, member by member: see load_ray().
FN void copy_met(const Met* from, Met* to) {
  to->tau = from->tau;
  to->alpha = from->alpha;
  for (int c = 0; c < 3; ++c) to->feature[c] = from->feature[c];
#if REPLAY
  to->place = from->place;
#endif
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
#if ACTOR_IDS
  met->feature[0] = (F)(real)actor_of[particle];
  met->feature[1] = met->feature[2] = (F)R(0.0);
#elif RAY_SH
  ray_feature(params, stride, particle, actor_of, actors, d, met->feature);
#else
  for (int c = 0; c < 3; ++c) met->feature[c] = (F)record[SIM_R_FEATURE + c];
#endif
}

#if REPLAY

/// What V rays blend once more, knowing how it ends.
typedef struct {
  F transmittance;
  F behind;  // g . (what is still to come): features, distance and the last transmittance
  F g[3], g_distance;
  I going;
  __global real* replayed;  // of the list's first place and the vector's first ray
} Light;

/// out, grad_out: those of render_bwd(), from the vector's first slot on.
FN void start_light(const RayLanes* ray,
                    __global const real* out,
                    __global const real* grad_out,
                    uint slots,
                    __global real* replayed,
                    Light* light) {
  light->transmittance = (F)R(1.0);
  light->replayed = replayed;
  light->going = is_ray(ray->d[0], ray->d[1], ray->d[2]);
  for (int c = 0; c < 3; ++c) light->g[c] = LDV(grad_out + (ulong)c * slots);
  light->g_distance = LDV(grad_out + SIM_O_DISTANCE * slots);
  light->behind = behind_of(out, grad_out, slots);
}

/// Nothing blended at a place, until something is.
FN void clear_place(uint place, __global real* replayed) {
  STV(replayed + (ulong)place * REPLAYED, (F)R(0.0));
  STV(replayed + (ulong)place * REPLAYED + TILE_RAYS, (F)R(0.0));
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
  // Rays of a vector have mostly met the same particle as their nearest.
  while (ANY(blends)) {
    const real place = HMAX(SEL(blends, met->place, (F)R(-1.0)));
    const I here = AND(blends, met->place == place);
    __global real* weights = light->replayed + (ulong)place * REPLAYED;
    STV(weights, SEL(here, weight, LDV(weights)));
    STV(weights + TILE_RAYS, SEL(here, d_log, LDV(weights + TILE_RAYS)));
    blends = AND(blends, NOT(here));
  }
}

#else

/// What V rays have blended so far.
typedef struct {
  F transmittance, distance, median;
  F sum[3];
  F last;  // m, tau of what was blended last
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
#if ACTOR_IDS
  const F halfway = met->feature[0];
#else
  const F halfway = met->tau;
#endif
  light->median = SEL(AND(before > R(0.5), left <= R(0.5)), halfway, light->median);
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

#endif

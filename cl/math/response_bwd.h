// response_bwd.h - gradients of responses, for render_bwd of lanes and of groups.
// Build: ORIGINS as in response.h.
#ifndef SIMULI_CL_MATH_RESPONSE_BWD_H
#define SIMULI_CL_MATH_RESPONSE_BWD_H
#include "math/blend_bwd.h"

/// Blends a response as render() does and returns its weight. g0, g1, g2, gd: dL/d(features, distance).
/// out d_log: dL/d ln alpha; none through the clamp of alpha, but tau keeps its gradient
/// io  transmittance; behind: g . (remaining contribution)
FN F blend_back(const real* record,
                const Response* response,
                real log_cut,
                F g0,
                F g1,
                F g2,
                F gd,
                F* transmittance,
                F* behind,
                F* d_log) {
  const I inside = response->inside;
  const F alpha = alpha_of(inside, record, response->q, log_cut);
  const F weight = alpha * *transmittance;
  F value = g0 * record[SIM_R_FEATURE];
  value = fma(g1, (F)record[SIM_R_FEATURE + 1], value);
  value = fma(g2, (F)record[SIM_R_FEATURE + 2], value);
  value = fma(gd, SEL(inside, response->tau, (F)R(0.0)), value);
  *d_log = log_alpha_gradient(inside, alpha, weight, *transmittance, value, behind);
  *transmittance = *transmittance - weight;
  return weight;
}

/// Adds the gradients of the particle's record from rays that blend it with `weight`.
/// io  sum[SIM_GRAD]
FN void add_gradients(const real* record,
                      const RayLanes* seen,
                      const Response* response,
                      F weight,
                      F d_log,
                      F g0,
                      F g1,
                      F g2,
                      F gd,
                      F* sum) {
  const I inside = response->inside;
  const F tau = SEL(inside, response->tau, (F)R(0.0));
  const F inv_n = SEL(inside, response->inv_n, (F)R(0.0));
  const F q = SEL(inside, response->q, (F)R(0.0));
  sum[SIM_G_FEATURE] = fma(weight, g0, sum[SIM_G_FEATURE]);
  sum[SIM_G_FEATURE + 1] = fma(weight, g1, sum[SIM_G_FEATURE + 1]);
  sum[SIM_G_FEATURE + 2] = fma(weight, g2, sum[SIM_G_FEATURE + 2]);
  sum[SIM_G_OPACITY] += d_log;
  const F dq = d_log * R(-0.5);
  const F dtau = weight * gd;

  // q = r^2 |o x a|^2 / |a|^2, tau = -(o . a) / |a|^2 with o = (0, 0, -1) + A delta.
  const F two_q = R(2.0) * dq;
  const F radial = two_q * record[SIM_R_RADIUS2];
  const F scale_q = radial * inv_n;
  const F along_a = (two_q * q + R(2.0) * dtau * tau) * inv_n;
  F da[3], origin[3];  // dL/d(direction, origin in the particle's frame)
#if ORIGINS
  const F o2 = fma(
      response->o[0], response->o[0], fma(response->o[1], response->o[1], response->o[2] * response->o[2]));
  SIM_EACH(k, 3) {
    const F a = SEL(inside, response->a[k], (F)R(0.0));
    const F o = response->o[k];
    // d|o x a|^2/da = 2 (o^2 a - (o.a) o), d|o x a|^2/do = 2 (n o - (o.a) a), and -(o.a) = n tau.
    da[k] = fma(fma(scale_q, o2, -along_a), a, (radial * tau - dtau * inv_n) * o);
    origin[k] = fma(radial, fma(tau, a, o), -(dtau * inv_n * a));
  }
#else
  const F a0 = SEL(inside, response->a[0], (F)R(0.0));
  const F a1 = SEL(inside, response->a[1], (F)R(0.0));
  const F a2 = SEL(inside, response->a[2], (F)R(0.0));
  da[0] = fma(scale_q, a0, -(along_a * a0));
  da[1] = fma(scale_q, a1, -(along_a * a1));
  da[2] = fma(dtau, inv_n, -(along_a * a2));
  // do: 2 r^2 (a2 a0, a2 a1, -(a0^2 + a1^2)) / n - a dtau / n.
  const F s2 = scale_q * a2 - dtau * inv_n;
  origin[0] = s2 * a0;
  origin[1] = s2 * a1;
  origin[2] = -(scale_q * fma(a0, a0, a1 * a1)) - dtau * inv_n * a2;
#endif
  SIM_EACH(k, 3) {
    SIM_EACH(c, 3) {
      sum[SIM_G_MATRIX + 3 * k + c] = fma(da[k], seen->d[c], sum[SIM_G_MATRIX + 3 * k + c]);
#if ORIGINS
      sum[SIM_G_MATRIX + 3 * k + c] = fma(origin[k], seen->o[c], sum[SIM_G_MATRIX + 3 * k + c]);
#endif
    }
    sum[SIM_G_ORIGIN + k] += origin[k];
  }
}

#endif

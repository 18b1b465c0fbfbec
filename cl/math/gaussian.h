// gaussian.h - a particle's parameters on lanes, and the blending matrix used by project and its gradient.
#ifndef SIMULI_CL_MATH_GAUSSIAN_H
#define SIMULI_CL_MATH_GAUSSIAN_H
#include "math/actor.h"
#include "math/elementary.h"
#include "math/rotation.h"
#include "shared/layout.h"

// Build: COMPENSATION = 1 reduces opacities to compensate for the footprint filter.
#ifndef COMPENSATION
#define COMPENSATION 0
#endif

/// Parameters of a particle needed for blending, except features.
typedef struct {
  F offset[3];      // mu - o_ref, m
  F range;          // |offset|, m
  F scale[3];       // s, m
  F filtered[3];    // s^ = sqrt(s^2 + kappa range^2), m
  F rotation[9];    // R, row-major: columns are the particle's axes in the world
  F quaternion[4];  // normalised
  F inv_norm;       // 1 / |raw quaternion|
#if ACTORS
  ActorLanes actor;
#endif
} Gaussian;

/// Loads positions of particles i .. i+V-1, of actors at mid-frame: offset, range, actor.
/// deform_offset[3][stride] of deform.cl with DEFORM.
FN void load_place(__global const real* params,
                   __global const uint* actor_of,
                   __global const ActorConstants* actors,
                   __global const real* deform_offset,
                   uint stride,
                   uint i,
                   __global const SensorConstants* sensor,
                   Gaussian* g) {
  const __global real* row = params + i;
  SIM_EACH(k, 3) {
    g->offset[k] = LDV(row + (SIM_MEAN + k) * stride) - sensor->centre_ref[k];
  }
#if ACTORS
  load_actors(actor_of, actors, i, &g->actor);
  if (g->actor.any) {
    F mean[3], turned[3];
    SIM_EACH(k, 3) mean[k] = LDV(row + (SIM_MEAN + k) * stride);
#if DEFORM
    SIM_EACH(k, 3) mean[k] += LDV(deform_offset + k * stride + i);
#endif
    rotate_lanes(g->actor.rotation, mean, turned);
    SIM_EACH(k, 3) {
      g->offset[k] = SEL(g->actor.on, g->actor.centre[k] + turned[k], g->offset[k]);
    }
  }
#endif
  const F range2 = g->offset[0] * g->offset[0] + g->offset[1] * g->offset[1] + g->offset[2] * g->offset[2];
  g->range = sqrt(range2);
}

/// Loads scales and rotations (METHOD section 8: the footprint filter widens all axes alike).
FN void load_shape(
    __global const real* params, uint stride, uint i, __global const SensorConstants* sensor, Gaussian* g) {
  const __global real* row = params + i;
  const F range2 = g->offset[0] * g->offset[0] + g->offset[1] * g->offset[1] + g->offset[2] * g->offset[2];
  const F widen = range2 * sensor->model.kappa;
  SIM_EACH(k, 3) {
    g->scale[k] = exp_lanes(LDV(row + (SIM_LOG_SCALE + k) * stride));
    g->filtered[k] = sqrt(fma(g->scale[k], g->scale[k], widen));
  }
  g->inv_norm = load_rotation(row, stride, g->quaternion, g->rotation);
#if ACTORS
  if (g->actor.any) {
    F own[9];
    SIM_EACH(k, 9) own[k] = g->rotation[k];
    multiply_lanes(g->actor.rotation, own, g->rotation);
  }
#endif
}

/// Loads positions and shapes.
FN void load_gaussian(__global const real* params,
                      __global const uint* actor_of,
                      __global const ActorConstants* actors,
                      __global const real* deform_offset,
                      uint stride,
                      uint i,
                      __global const SensorConstants* sensor,
                      Gaussian* g) {
  load_place(params, actor_of, actors, deform_offset, stride, i, sensor, g);
  load_shape(params, stride, i, sensor, g);
}

/// Unit vector from o_ref to the particle at mid-frame, in its actor's axes: the argument of SH. At the
/// record's own time it would combine a moved actor with an unmoved sensor.
FN void view_direction(const Gaussian* g, F* towards) {
  const F inv_range = R(1.0) / g->range;
  SIM_EACH(k, 3) towards[k] = g->offset[k] * inv_range;
#if ACTORS
  if (g->actor.any) {
    const F direction[3] = {towards[0], towards[1], towards[2]};
    rotate_back_lanes(g->actor.rotation, direction, towards);
  }
#endif
}

#if COMPENSATION
/// sqrt(|S_perp| / |S^_perp|), the factor of a particle's opacity when the footprint filter widens it (METHOD
/// section 8), seen along its direction n. Scales are relative to the largest widened scale, so that products
/// of four stay in range.
typedef struct {
  F n[3];          // offset / range
  F e[3];          // R^T n
  F scale2[3];     // s^2 relative to the largest s^^2
  F filtered2[3];  // s^^2 relative to the largest s^^2
  F inv_largest2;  // 1 / m^2
  F inv_area;      // 1 / A(s)
  F inv_wide;      // 1 / A(s^)
  F log_share;     // ln of the share
} Compensation;

FN void compensation(const Gaussian* g, Compensation* c) {
  const F largest = VMAX(g->filtered[0], VMAX(g->filtered[1], g->filtered[2]));
  const F inv = R(1.0) / largest;
  c->inv_largest2 = inv * inv;
  SIM_EACH(k, 3) {
    const F s = g->scale[k] * inv, wide = g->filtered[k] * inv;
    c->scale2[k] = s * s;
    c->filtered2[k] = wide * wide;
    c->n[k] = g->offset[k] / g->range;
  }
  F area = (F)R(0.0), wide = (F)R(0.0);
  SIM_EACH(k, 3) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    c->e[k] = g->rotation[k] * c->n[0] + g->rotation[3 + k] * c->n[1] + g->rotation[6 + k] * c->n[2];
    const F e2 = c->e[k] * c->e[k];
    area = fma(e2, c->scale2[i] * c->scale2[j], area);
    wide = fma(e2, c->filtered2[i] * c->filtered2[j], wide);
  }
  c->inv_area = R(1.0) / area;
  c->inv_wide = R(1.0) / wide;
  c->log_share = R(0.5) * log(area * c->inv_wide);
}

/// Adds the gradient `by_share` = dL/d(ln share) to the gradients of R (row-major), ln s and the mean.
FN void compensation_gradient(const Gaussian* g,
                              const Compensation* c,
                              F by_share,
                              real kappa,
                              F* g_rotation,
                              F* g_log_scale,
                              F* g_mean) {
  F by_wide = (F)R(0.0);  // sum of d(ln A(s^)) / d(s^^2)
  F by_n[3] = {(F)R(0.0), (F)R(0.0), (F)R(0.0)};
  SIM_EACH(k, 3) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const F e2_i = c->e[i] * c->e[i], e2_j = c->e[j] * c->e[j];
    const F narrow = fma(e2_i, c->scale2[j], e2_j * c->scale2[i]) * c->inv_area;
    const F wide = fma(e2_i, c->filtered2[j], e2_j * c->filtered2[i]) * c->inv_wide;
    by_wide += wide;
    g_log_scale[k] = fma(by_share * c->scale2[k], narrow - wide, g_log_scale[k]);
    const F by_e =
        by_share * c->e[k] *
        (c->scale2[i] * c->scale2[j] * c->inv_area - c->filtered2[i] * c->filtered2[j] * c->inv_wide);
    SIM_EACH(r, 3) {
      g_rotation[3 * r + k] = fma(by_e, c->n[r], g_rotation[3 * r + k]);
      by_n[r] = fma(by_e, g->rotation[3 * r + k], by_n[r]);
    }
  }
  const F radial = by_n[0] * c->n[0] + by_n[1] * c->n[1] + by_n[2] * c->n[2];
  const F by_range2 = -kappa * by_share * by_wide * c->inv_largest2;  // multiplied by offset
  SIM_EACH(r, 3) {
    g_mean[r] += (by_n[r] - radial * c->n[r]) / g->range + by_range2 * g->offset[r];
  }
}
#endif

#if ACTOR_MOTION
/// Moves particles of moving actors from mid-frame to time t: offset, range, rotation, and the actor's
/// rotation. velocity: m per frame, 0 at rest. The footprint filter stays that of mid-frame.
FN void place_at(Gaussian* g, F t, F* velocity) {
  SIM_EACH(k, 3) velocity[k] = (F)R(0.0);
  if (!g->actor.any) return;
  F turn[9], turned[9], moved[3];
  actor_turn(&g->actor, t, turn);
  actor_carry(&g->actor, turn, t, g->offset, moved);
  SIM_EACH(k, 3) g->offset[k] = moved[k];
  const F range = sqrt(moved[0] * moved[0] + moved[1] * moved[1] + moved[2] * moved[2]);
  g->range = SEL(g->actor.on, range, g->range);
  multiply_lanes(turn, g->rotation, turned);
  SIM_EACH(k, 9) g->rotation[k] = SEL(g->actor.on, turned[k], g->rotation[k]);
  multiply_lanes(turn, g->actor.rotation, turned);
  SIM_EACH(k, 9) g->actor.rotation[k] = SEL(g->actor.on, turned[k], g->actor.rotation[k]);
  F arm[3], spun[3];
  SIM_EACH(k, 3) {
    arm[k] = moved[k] - g->actor.centre[k] - g->actor.step[k] * (t - R(0.5));
  }
  cross_lanes(g->actor.axis, arm, spun);
  SIM_EACH(k, 3) {
    velocity[k] = SEL(g->actor.on, fma(g->actor.angle, spun[k], g->actor.step[k]), (F)R(0.0));
  }
}
#endif

/// The blending matrix: M = diag(1/s^) R^T, o_g = -M offset, r = |o_g|, and A = G D H M / r, where the
/// Householder reflection H maps o_g to (0, 0, -+r), the sign D makes it (0, 0, -r), and the rotation G about
/// the third axis makes A[0][2] = 0.
typedef struct {
  F m[9];          // M, row-major
  F a[9];          // A, row-major
  F radius2;       // r^2
  F inv_radius;    // 1 / r
  F v[3];          // Householder vector
  F two_over_vv;   // 2 / |v|^2
  F sign;          // last entry of D
  F cosine, sine;  // of G
} BlendMatrix;

FN void blend_matrix(const Gaussian* g, BlendMatrix* b) {
  F o[3];
  SIM_EACH(i, 3) {
    const F inv_scale = R(1.0) / g->filtered[i];
    SIM_EACH(j, 3) b->m[3 * i + j] = g->rotation[3 * j + i] * inv_scale;
    o[i] = -(b->m[3 * i] * g->offset[0] + b->m[3 * i + 1] * g->offset[1] + b->m[3 * i + 2] * g->offset[2]);
  }
  b->radius2 = o[0] * o[0] + o[1] * o[1] + o[2] * o[2];
  const F r = sqrt(b->radius2);
  b->inv_radius = R(1.0) / r;
  // Adding a number with the sign of o_z never cancels; H then maps o_g to -sign(o_z) r e3.
  const F side = SEL(o[2] < R(0.0), (F)R(-1.0), (F)R(1.0));
  b->v[0] = o[0];
  b->v[1] = o[1];
  b->v[2] = o[2] + side * r;
  b->two_over_vv = R(2.0) / (b->v[0] * b->v[0] + b->v[1] * b->v[1] + b->v[2] * b->v[2]);
  b->sign = side;
  SIM_EACH(j, 3) {
    const F vm = (b->v[0] * b->m[j] + b->v[1] * b->m[3 + j] + b->v[2] * b->m[6 + j]) * b->two_over_vv;
    b->a[j] = (b->m[j] - b->v[0] * vm) * b->inv_radius;
    b->a[3 + j] = (b->m[3 + j] - b->v[1] * vm) * b->inv_radius;
    b->a[6 + j] = (b->m[6 + j] - b->v[2] * vm) * b->inv_radius * b->sign;
  }
  const F length2 = b->a[2] * b->a[2] + b->a[5] * b->a[5];
  const I turned = length2 > R(1e-30);
  const F inv_length = R(1.0) / sqrt(SEL(turned, length2, (F)R(1.0)));
  b->cosine = SEL(turned, b->a[5] * inv_length, (F)R(1.0));
  b->sine = SEL(turned, b->a[2] * inv_length, (F)R(0.0));
  SIM_EACH(j, 3) {
    const F first = b->a[j], second = b->a[3 + j];
    b->a[j] = b->cosine * first - b->sine * second;
    b->a[3 + j] = b->sine * first + b->cosine * second;
  }
}

/// Transforms a gradient in rows of A (scaled, reflected, rotated) back to the frame of M: out = H D G^T in /
/// r.
FN void unreflect(const BlendMatrix* b, const F* in, F* out) {
  const F first = b->cosine * in[0] + b->sine * in[1];
  const F second = b->cosine * in[1] - b->sine * in[0];
  const F last = in[2] * b->sign;
  const F dot = (b->v[0] * first + b->v[1] * second + b->v[2] * last) * b->two_over_vv;
  out[0] = (first - b->v[0] * dot) * b->inv_radius;
  out[1] = (second - b->v[1] * dot) * b->inv_radius;
  out[2] = (last - b->v[2] * dot) * b->inv_radius;
}

#endif

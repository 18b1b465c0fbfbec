// ellipsoid.h - the cutoff ellipsoid of a particle {x : (x - mu)^T S^-1 (x - mu) <= qmax}, outside of which no
// ray has alpha >= alpha_cut, in the sensor frame: its axes, tangent planes through the sensor, and angular
// bounds.
// Rays with other origins or times than the reference pose see a shifted ellipsoid; the ellipsoid is enlarged
// by the largest shift. All bounds are conservative.
#ifndef SIMULI_CL_MATH_ELLIPSOID_H
#define SIMULI_CL_MATH_ELLIPSOID_H
#include "math/gaussian.h"
#include "math/shutter.h"

/// The ellipsoid p + sum_k z_k a_k, |z| <= 1, in the sensor frame. Its matrix B = sum_k a_k a_k^T is enlarged
/// to share * B + more * I, which contains the ellipsoid shifted by up to `shift`.
typedef struct {
  F p[3];     // m; for a LiDAR relative to its reference height
  F a[3][3];  // a[coordinate][k], m
  F share, more;
  F ball;  // radius in m of a ball that contains it
} Ellipsoid;

/// Upper bound in m of the shift of particle g at distance `distance`, seen by rays with times in [first,
/// last], relative to its position at the middle of the interval.
FN F shift_within(
    __global const SensorConstants* sensor, const Gaussian* g, F radius, F distance, F first, F last) {
  F shift = (F)sensor->model.lever;
#if MOVING
  // A rotation by d moves a point by at most d times its distance.
  const real step = centre_path(sensor);
  shift += R(0.5) * (last - first) * (step + carried(g, radius) + sensor->turn_angle * (distance + radius));
#endif
  return shift;
}

/// Enlarges the ellipsoid for all rays with times in [first, last]. Minkowski sum with a ball: (1 + 1/c) B + (1
/// + c) m^2 I for any c > 0, here c = sqrt(tr B / 3) / m.
FN void seen_ellipsoid(__global const SensorConstants* sensor,
                       const Gaussian* g,
                       F reach,
                       F radius,
                       F first,
                       F last,
                       Ellipsoid* e) {
  const F t = R(0.5) * (first + last);
#if MOVING
  F sine, cosine;
  sincos_lanes(sensor->turn_angle * t, &sine, &cosine);
#endif
#if ACTOR_MOTION
  F carry[9];
  if (g->actor.any) actor_turn(&g->actor, t, carry);
#endif
  F trace = (F)R(0.0);
  SIM_EACH(k, 3) {
    const F length = reach * g->filtered[k];
    F v[3] = {g->rotation[k] * length, g->rotation[3 + k] * length, g->rotation[6 + k] * length};
#if ACTOR_MOTION
    if (g->actor.any) {
      F carried_v[3];
      rotate_lanes(carry, v, carried_v);
      SIM_EACH(j, 3) v[j] = SEL(g->actor.on, carried_v[j], v[j]);
    }
#endif
    F turned[3];
#if MOVING
    rotate(sensor->rotation_start, v, turned);
    turn(sensor->turn_axis, -sine, cosine, turned);
#else
    rotate(sensor->rotation_ref, v, turned);
#endif
    SIM_EACH(j, 3) e->a[j][k] = turned[j];
    trace += length * length;
  }
  sensor_from_particle_point(sensor, g, g->offset, t, e->p);
  const F distance = sqrt(e->p[0] * e->p[0] + e->p[1] * e->p[1] + e->p[2] * e->p[2]);
  const F shift = shift_within(sensor, g, radius, distance, first, last);
  e->p[2] -= sensor->model.height;
  const F mean = VMAX(sqrt(trace * R(0.33333333333333333)),
                      (F)R(1e-6));  // mean radius; any positive value gives valid bounds
  e->share = R(1.0) + shift / mean;
  e->more = shift * (shift + mean);
  e->ball = radius + shift;
}

/// Slopes (across / along) of the two tangents from the origin to an ellipse with its centre at distance `far`
/// along the axis and the second moments along, mixed, across: s^2 (far^2 - along) + 2 s mixed - across = 0.
/// Returns false where the origin is inside, or so near that tangents are unbounded. low <= 0 <= high.
FN I tangent_slopes(F far2, F along, F mixed, F across, F* low, F* high) {
  const I outside = far2 - along > R(1e-4) * far2;
  const F room = SEL(outside, far2 - along, (F)R(1.0));
  // Both roots without cancellation: their product is -across / room.
  const F sum = fabs(mixed) + sqrt(fma(mixed, mixed, across * room));
  const F large = sum / room;
  const F small = SEL(sum > R(0.0), across / SEL(sum > R(0.0), sum, (F)R(1.0)), (F)R(0.0));
  *low = SEL(mixed > R(0.0), -large, -small);
  *high = SEL(mixed > R(0.0), small, large);
  return AND(outside, sum < R(1e18));  // otherwise squares may have overflowed floats
}

/// Tangents to the ellipsoid's projection on a plane, with the centre at (pu, pv) and the axes (au[k], av[k]).
/// Slopes are relative to the line of sight, positive from u towards v.
FN I shadow_slopes(const Ellipsoid* e, F pu, F pv, const F* au, const F* av, F* low, F* high) {
  const F far2 = fma(pu, pu, pv * pv);
  const F inv = SEL(far2 > R(0.0), R(1.0) / sqrt(SEL(far2 > R(0.0), far2, (F)R(1.0))), (F)R(0.0));
  F along = (F)R(0.0), mixed = (F)R(0.0), across = (F)R(0.0);
  SIM_EACH(k, 3) {
    const F l = fma(pu, au[k], pv * av[k]) * inv;
    const F w = fma(pu, av[k], -(pv * au[k])) * inv;
    along = fma(l, l, along);
    mixed = fma(l, w, mixed);
    across = fma(w, w, across);
  }
  return tangent_slopes(
      far2, fma(e->share, along, e->more), e->share * mixed, fma(e->share, across, e->more), low, high);
}

/// Slope of tangents to a ball relative to the line to its centre; NO_BOUND where they are unbounded.
FN F ball_slope(F distance2, F ball) {
  const F room = fma(ball, -ball, distance2);
  const I outside = room > R(1e-4) * distance2;
  return SEL(outside, ball / sqrt(SEL(outside, room, (F)R(1.0))), (F)NO_BOUND);
}

/// Bounds of v / u between the lines through the origin with slopes [right, left] relative to the direction
/// (pu, pv), where u > 0; +-NO_BOUND where there is no bound.
FN void slope_ratios(F pu, F pv, I bounded, F right, F left, F* low, F* high) {
  SIM_EACH(end, 2) {
    const F slope = end == 0 ? right : left;
    const F ahead = fma(-pv, slope, pu);
    const I in_front = AND(bounded, ahead > R(1e-4) * (fabs(pu) + fabs(pv * slope)));
    const F ratio = fma(pu, slope, pv) / SEL(in_front, ahead, (F)R(1.0));
    if (end == 0) *low = SEL(in_front, ratio, (F)-NO_BOUND);
    if (end == 1) *high = SEL(in_front, ratio, (F)NO_BOUND);
  }
}

/// The same bounds for the ellipsoid's projection.
FN void shadow_ratios(const Ellipsoid* e, F pu, F pv, const F* au, const F* av, F* low, F* high) {
  F right, left;
  const I outside = shadow_slopes(e, pu, pv, au, av, &right, &left);
  slope_ratios(pu, pv, outside, right, left, low, high);
}

/// Bounds of azimuth atan2(b, a) and elevation atan2(c, hypot(a, b)) of coordinates a, b, c: azimuth + [from,
/// to] and [low, high], rad.
FN void spherical_extent(
    const Ellipsoid* e, int a, int b, int c, F* azimuth, F* from, F* to, F* low, F* high) {
  const F pa = e->p[a], pb = e->p[b], pc = e->p[c];
  const F flat2 = fma(pa, pa, pb * pb);
  const F flat = sqrt(flat2);
  *azimuth = atan2_lanes(pb, pa);
  F right, left;
  const I aside = shadow_slopes(e, pa, pb, e->a[a], e->a[b], &right, &left);
  *from = SEL(aside, atan2_lanes(right, (F)R(1.0)), (F)-NO_BOUND);
  *to = SEL(aside, atan2_lanes(left, (F)R(1.0)), (F)NO_BOUND);

  // All points are within the ball, and no point of a cap differs in elevation by more than the cap's angle.
  const F elevation = atan2_lanes(pc, flat);
  const F room = fma(pc, pc, flat2) - e->ball * e->ball;
  const F cap = SEL(room > R(0.0), atan2_lanes(e->ball, sqrt(VMAX(room, (F)R(0.0)))), (F)R(4.0));
  *low = elevation - cap;
  *high = elevation + cap;

  // Planes through the origin that contain the horizontal line across the line of sight: c <= u a' for all
  // points, with a' their horizontal coordinate along it. The horizontal distance is in [a', a' / cos(azimuth
  // relative to the line)], so c / distance is at most u where u >= 0, else u times the smallest cosine.
  const F inv = R(1.0) / SEL(aside, flat, (F)R(1.0));
  F along[3];
  SIM_EACH(k, 3) along[k] = fma(pa, e->a[a][k], pb * e->a[b][k]) * inv;
  F under, over;
  shadow_ratios(e, flat, pc, along, e->a[c], &under, &over);
  const F widest = VMAX(-right, left);
  const F cosine = R(1.0) / sqrt(fma(widest, widest, (F)R(1.0)));
  under = SEL(under > R(0.0), under * cosine, under);
  over = SEL(over < R(0.0), over * cosine, over);
  *low = SEL(aside, VMAX(*low, atan2_lanes(under, (F)R(1.0))), *low);
  *high = SEL(aside, VMIN(*high, atan2_lanes(over, (F)R(1.0))), *high);
}

#endif

// extent.h - where on the sensor a particle can contribute at all: extent = exact (METHOD section 4).
// A ray gets alpha >= alpha_cut only where it meets the cutoff ellipsoid {x : (x - mu)^T S^-1 (x - mu) <=
// qmax}. Everything here bounds the cone of that ellipsoid from the sensor, never too small. Rays that start
// or fire elsewhere than in the pose looked from see a shifted ellipsoid: it is blown up by how far it may be
// shifted.
#ifndef SIMULI_CL_MATH_EXTENT_H
#define SIMULI_CL_MATH_EXTENT_H
#include "math/unscented.h"

#define EXTENT_UNSCENTED 0
#define EXTENT_EXACT 1
#ifndef EXTENT
#define EXTENT EXTENT_UNSCENTED
#endif

// How often the time that a particle is seen in is narrowed down, the first look at the whole frame included.
#define EXACT_ROUNDS 3
// Rounding of floats: the bounds are this much wider than the mathematics (share of the half width, px, rad).
#define PAD_SHARE R(1e-3)
#define PAD_PX R(0.02)
#define PAD_RAD R(3e-6)

/// The ellipsoid p + sum_k z_k a_k, |z| <= 1, in the sensor frame, its matrix B = sum_k a_k a_k^T taken to
/// stretch * B + more * I, which contains it moved by anything up to `shift`.
typedef struct {
  F p[3];     // m; of a LiDAR from its reference height
  F a[3][3];  // a[coordinate][k], m
  F stretch, more;
  F ball;  // m, radius of a ball that contains it
} Ellipsoid;

/// Bounds in pixels or rad.
typedef struct {
  F mean_x, half_x, low, high;
} Extent;

/// The ellipsoid as seen by every ray whose time is in [first, last].
/// Minkowski sum with a ball: (1 + 1/c) B + (1 + c) m^2 I for any c > 0, here c = sqrt(tr B / 3) / m.
FN void seen_ellipsoid(
    __global const real* sensor, const Gaussian* g, F reach, F radius, F first, F last, Ellipsoid* e) {
  const F t = R(0.5) * (first + last);
#if MOVING
  F sine, cosine;
  sincos_lanes(sensor[SIM_S_ANGLE] * t, &sine, &cosine);
#endif
#if ACTOR_MOTION
  F carry[9];
  if (g->actor.any) actor_turn(&g->actor, t, carry);
#endif
  F trace = (F)R(0.0);
  for (int k = 0; k < 3; ++k) {
    const F length = reach * g->filtered[k];
    F v[3] = {g->rotation[k] * length, g->rotation[3 + k] * length, g->rotation[6 + k] * length};
#if ACTOR_MOTION
    if (g->actor.any) {
      F carried_v[3];
      rotate_lanes(carry, v, carried_v);
      for (int j = 0; j < 3; ++j) v[j] = SEL(g->actor.on, carried_v[j], v[j]);
    }
#endif
    F turned[3];
#if MOVING
    rotate(sensor + SIM_S_ROT_START, v, turned);
    turn(sensor + SIM_S_AXIS, -sine, cosine, turned);
#else
    rotate(sensor + SIM_S_ROT_REF, v, turned);
#endif
    for (int j = 0; j < 3; ++j) e->a[j][k] = turned[j];
    trace += length * length;
  }
  sensor_from_particle_point(sensor, g, g->offset, t, e->p);
  F shift = (F)sensor[SIM_S_LEVER];
#if MOVING
  // A turn by d moves a point by at most d times its distance.
  const F dt = R(0.5) * (last - first);
  const F distance = sqrt(e->p[0] * e->p[0] + e->p[1] * e->p[1] + e->p[2] * e->p[2]);
  const real step = sqrt(sensor[SIM_S_CENTRE_STEP] * sensor[SIM_S_CENTRE_STEP] +
                         sensor[SIM_S_CENTRE_STEP + 1] * sensor[SIM_S_CENTRE_STEP + 1] +
                         sensor[SIM_S_CENTRE_STEP + 2] * sensor[SIM_S_CENTRE_STEP + 2]);
  shift += dt * (step + carried(g, radius) + sensor[SIM_S_ANGLE] * (distance + radius));
#endif
  e->p[2] -= sensor[SIM_S_HEIGHT_REF];
  const F mean = VMAX(sqrt(trace * R(0.33333333333333333)), (F)R(1e-6));  // of the radii; c may be any
  e->stretch = R(1.0) + shift / mean;
  e->more = shift * (shift + mean);
  e->ball = radius + shift;
}

/// Slopes across / along of the two tangents from the origin to an ellipse whose centre is `far` along, with
/// the second moments along, mixed, across: s^2 (far^2 - along) + 2 s mixed - across = 0. False where the
/// origin is inside, or so near that tangents run off. low <= 0 <= high.
FN I tangent_slopes(F far2, F along, F mixed, F across, F* low, F* high) {
  const I outside = far2 - along > R(1e-4) * far2;
  const F room = SEL(outside, far2 - along, (F)R(1.0));
  // The two roots without cancellation: their product is -across / room.
  const F sum = fabs(mixed) + sqrt(fma(mixed, mixed, across * room));
  const F large = sum / room;
  const F small = SEL(sum > R(0.0), across / SEL(sum > R(0.0), sum, (F)R(1.0)), (F)R(0.0));
  *low = SEL(mixed > R(0.0), -large, -small);
  *high = SEL(mixed > R(0.0), small, large);
  return AND(outside, sum < R(1e18));  // else squares may have left the range of floats
}

/// Tangents to the ellipsoid's shadow on a plane, with the centre at (pu, pv) and the axes (au[k], av[k]).
/// The slopes are those off the line of sight, positive from u towards v.
FN I shadow_slopes(const Ellipsoid* e, F pu, F pv, const F* au, const F* av, F* low, F* high) {
  const F far2 = fma(pu, pu, pv * pv);
  const F inv = SEL(far2 > R(0.0), R(1.0) / sqrt(SEL(far2 > R(0.0), far2, (F)R(1.0))), (F)R(0.0));
  F along = (F)R(0.0), mixed = (F)R(0.0), across = (F)R(0.0);
  for (int k = 0; k < 3; ++k) {
    const F l = fma(pu, au[k], pv * av[k]) * inv;
    const F w = fma(pu, av[k], -(pv * au[k])) * inv;
    along = fma(l, l, along);
    mixed = fma(l, w, mixed);
    across = fma(w, w, across);
  }
  return tangent_slopes(
      far2, fma(e->stretch, along, e->more), e->stretch * mixed, fma(e->stretch, across, e->more), low, high);
}

/// Bounds of v / u over the part of the shadow where u > 0; +-NO_BOUND where there is none.
FN void shadow_ratios(const Ellipsoid* e, F pu, F pv, const F* au, const F* av, F* low, F* high) {
  F slope[2];
  const I outside = shadow_slopes(e, pu, pv, au, av, &slope[0], &slope[1]);
  for (int end = 0; end < 2; ++end) {
    const F ahead = fma(-pv, slope[end], pu);
    const I bounded = AND(outside, ahead > R(1e-4) * (fabs(pu) + fabs(pv * slope[end])));
    const F ratio = fma(pu, slope[end], pv) / SEL(bounded, ahead, (F)R(1.0));
    if (end == 0) *low = SEL(bounded, ratio, (F)-NO_BOUND);
    if (end == 1) *high = SEL(bounded, ratio, (F)NO_BOUND);
  }
}

/// Azimuth atan2(b, a) and elevation atan2(c, hypot(a, b)) of the coordinates a, b, c: the interval
/// azimuth + [from, to] and [low, high], rad.
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

  // In any case all points are within the ball, and no point of a cap is farther off in elevation than its
  // angle.
  const F elevation = atan2_lanes(pc, flat);
  const F room = fma(pc, pc, flat2) - e->ball * e->ball;
  const F cap = SEL(room > R(0.0), atan2_lanes(e->ball, sqrt(VMAX(room, (F)R(0.0)))), (F)R(4.0));
  *low = elevation - cap;
  *high = elevation + cap;

  // Planes through the origin that contain the horizontal across the line of sight: c <= u a' for all points,
  // a' their horizontal coordinate along it. The horizontal distance is in [a', a' / cos(azimuth off the
  // line)]: c / distance is at most u where u >= 0, else u times the least cosine.
  const F inv = R(1.0) / SEL(aside, flat, (F)R(1.0));
  F along[3];
  for (int k = 0; k < 3; ++k) along[k] = fma(pa, e->a[a][k], pb * e->a[b][k]) * inv;
  F under, over;
  shadow_ratios(e, flat, pc, along, e->a[c], &under, &over);
  const F widest = VMAX(-right, left);
  const F cosine = R(1.0) / sqrt(fma(widest, widest, (F)R(1.0)));
  under = SEL(under > R(0.0), under * cosine, under);
  over = SEL(over < R(0.0), over * cosine, over);
  *low = SEL(aside, VMAX(*low, atan2_lanes(under, (F)R(1.0))), *low);
  *high = SEL(aside, VMIN(*high, atan2_lanes(over, (F)R(1.0))), *high);
}

#if SENSOR == SENSOR_CAMERA && LENS != SIM_LENS_PINHOLE && !WRAPS
/// Half the opening angle of the round cone about the line of sight that holds the ellipsoid; false where it
/// is not in front. n: unit vector to the centre, at `distance`.
FN I cap_angle(const Ellipsoid* e, const F* n, F distance, F* angle) {
  // Two directions across (Duff et al. 2017); every slope across is at most that of the largest moments.
  const F sign = SEL(n[2] < R(0.0), (F)R(-1.0), (F)R(1.0));
  const F share = R(-1.0) / (sign + n[2]);
  const F mixed_xy = n[0] * n[1] * share;
  const F e1[3] = {fma(sign * n[0], n[0] * share, (F)R(1.0)), sign * mixed_xy, -sign * n[0]};
  const F e2[3] = {mixed_xy, fma(n[1], n[1] * share, sign), -n[1]};
  F along = (F)R(0.0), m1 = along, m2 = along, w11 = along, w12 = along, w22 = along;
  for (int k = 0; k < 3; ++k) {
    const F l = n[0] * e->a[0][k] + n[1] * e->a[1][k] + n[2] * e->a[2][k];
    const F a1 = e1[0] * e->a[0][k] + e1[1] * e->a[1][k] + e1[2] * e->a[2][k];
    const F a2 = e2[0] * e->a[0][k] + e2[1] * e->a[1][k] + e2[2] * e->a[2][k];
    along = fma(l, l, along);
    m1 = fma(l, a1, m1);
    m2 = fma(l, a2, m2);
    w11 = fma(a1, a1, w11);
    w12 = fma(a1, a2, w12);
    w22 = fma(a2, a2, w22);
  }
  const F apart = R(0.5) * (w11 - w22);
  const F across = R(0.5) * (w11 + w22) + sqrt(fma(apart, apart, w12 * w12));
  F low, high;
  const I outside = tangent_slopes(distance * distance,
                                   fma(e->stretch, along, e->more),
                                   e->stretch * sqrt(fma(m1, m1, m2 * m2)),
                                   fma(e->stretch, across, e->more),
                                   &low,
                                   &high);
  *angle = atan2_lanes(VMAX(-low, high), (F)R(1.0));
  return outside;
}

/// The cap mapped through the lens: no image moves faster over the picture than the largest px per rad in the
/// cone in which the host looked for it. A cone of at most 90 degrees is convex: rays inside are nearer to
/// the cone's nearest direction than to the centre. A wider one must hold the cap, or the bound is the
/// picture.
FN void lens_extent(__global const real* sensor, const Ellipsoid* e, F* x0, F* x1, F* y0, F* y1) {
  const F distance = sqrt(e->p[0] * e->p[0] + e->p[1] * e->p[1] + e->p[2] * e->p[2]);
  const F inv = R(1.0) / VMAX(distance, (F)R(1e-18));
  F n[3] = {e->p[0] * inv, e->p[1] * inv, e->p[2] * inv};
  F cap;
  I bounded = cap_angle(e, n, distance, &cap);
  const F flat = sqrt(fma(n[0], n[0], n[1] * n[1]));
  const F off_axis = atan2_lanes(flat, n[2]);
  const real cone = sensor[SIM_S_LENS_CONE];
  if (cone > HALF_PI_R) {
    bounded = AND(bounded, off_axis + cap <= cone);
  } else {
    const I beyond = off_axis > cone;
    const F scale = sin(cone) / SEL(flat > R(0.0), flat, (F)R(1.0));
    n[0] = SEL(beyond, n[0] * scale, n[0]);
    n[1] = SEL(beyond, n[1] * scale, n[1]);
    n[2] = SEL(beyond, (F)cos(cone), n[2]);
  }
  F x, y;
  project_point(sensor, n, &x, &y, &bounded);
  const F half_x = cap * sensor[SIM_S_LENS_SLOPE_X];
  const F half_y = cap * sensor[SIM_S_LENS_SLOPE_Y];
  *x0 = SEL(bounded, x - half_x, (F)-NO_BOUND);
  *x1 = SEL(bounded, x + half_x, (F)NO_BOUND);
  *y0 = SEL(bounded, y - half_y, (F)-NO_BOUND);
  *y1 = SEL(bounded, y + half_y, (F)NO_BOUND);
}
#endif

/// The places that all rays with times in [first, last] see the particle at; x near `anchor` where it wraps.
FN void extent_during(__global const real* sensor,
                      const Gaussian* g,
                      F reach,
                      F radius,
                      F first,
                      F last,
                      F anchor,
                      Extent* out) {
  Ellipsoid e;
  seen_ellipsoid(sensor, g, reach, radius, first, last, &e);
#if WRAPS
  F azimuth, from, to;
#if SENSOR == SENSOR_LIDAR
  spherical_extent(&e, 0, 1, 2, &azimuth, &from, &to, &out->low, &out->high);
  const F x = (azimuth - sensor[SIM_S_AZIMUTH_CUT]) * sensor[SIM_S_SPIN];
  const real scale = sensor[SIM_S_SPIN];
  const F pad = (F)PAD_RAD, pad_y = PAD_RAD + sensor[SIM_S_ROW_SPREAD] + PAD_SHARE * (out->high - out->low);
#else
  spherical_extent(&e, 2, 0, 1, &azimuth, &from, &to, &out->low, &out->high);
  const F x = fma(azimuth, (F)sensor[SIM_S_FX], (F)sensor[SIM_S_CX]);
  out->low = fma(out->low, (F)sensor[SIM_S_FY], (F)sensor[SIM_S_CY]);
  out->high = fma(out->high, (F)sensor[SIM_S_FY], (F)sensor[SIM_S_CY]);
  const real scale = sensor[SIM_S_FX];
  const F pad = (F)PAD_PX, pad_y = PAD_PX + PAD_SHARE * (out->high - out->low);
#endif
  out->mean_x = unrolled(sensor, x, anchor) + R(0.5) * (from + to) * scale;
  out->half_x = R(0.5) * (to - from) * fabs(scale) * (R(1.0) + PAD_SHARE) + pad;
  out->low -= pad_y;
  out->high += pad_y;
#else
  F x0, x1, y0, y1;
#if LENS == SIM_LENS_PINHOLE
  shadow_ratios(&e, e.p[2], e.p[0], e.a[2], e.a[0], &x0, &x1);
  shadow_ratios(&e, e.p[2], e.p[1], e.a[2], e.a[1], &y0, &y1);
  x0 = fma(x0, (F)sensor[SIM_S_FX], (F)sensor[SIM_S_CX]);
  x1 = fma(x1, (F)sensor[SIM_S_FX], (F)sensor[SIM_S_CX]);
  y0 = fma(y0, (F)sensor[SIM_S_FY], (F)sensor[SIM_S_CY]);
  y1 = fma(y1, (F)sensor[SIM_S_FY], (F)sensor[SIM_S_CY]);
#else
  lens_extent(sensor, &e, &x0, &x1, &y0, &y1);
#endif
  // What is left of it in and just around the picture: else a far end would round the near one away.
  const real width = sensor[SIM_S_WIDTH] + R(1.0), height = sensor[SIM_S_HEIGHT] + R(1.0);
  const F pad_x = fma((F)PAD_SHARE, x1 - x0, (F)PAD_PX), pad_y = fma((F)PAD_SHARE, y1 - y0, (F)PAD_PX);
  x0 = VMIN(VMAX(x0 - pad_x, (F)R(-1.0)), (F)width);
  x1 = VMIN(VMAX(x1 + pad_x, (F)R(-1.0)), (F)width);
  out->mean_x = R(0.5) * (x0 + x1);
  out->half_x = R(0.5) * (x1 - x0);
  out->low = VMIN(VMAX(y0 - pad_y, (F)R(-1.0)), (F)height);
  out->high = VMIN(VMAX(y1 + pad_y, (F)R(-1.0)), (F)height);
#endif
}

/// Times of all rays whose place is within the extent, and with `whole` those of all rays.
FN void times_within(const FrameParams* frame,
                     __global const real* sensor,
                     const Extent* extent,
                     int whole,
                     F* first,
                     F* last) {
#if SENSOR == SENSOR_CAMERA
  const real width = sensor[SIM_S_WIDTH], height = sensor[SIM_S_HEIGHT];
  const F x0 = whole || WRAPS ? (F)R(0.0) : VMIN(VMAX(extent->mean_x - extent->half_x, (F)R(0.0)), (F)width);
  const F x1 = whole || WRAPS ? (F)width : VMIN(VMAX(extent->mean_x + extent->half_x, (F)R(0.0)), (F)width);
  const F y0 = whole ? (F)R(0.0) : VMIN(VMAX(extent->low, (F)R(0.0)), (F)height);
  const F y1 = whole ? (F)height : VMIN(VMAX(extent->high, (F)R(0.0)), (F)height);
  const F tx0 = x0 * sensor[SIM_S_TIME_X], tx1 = x1 * sensor[SIM_S_TIME_X];
  const F ty0 = y0 * sensor[SIM_S_TIME_Y], ty1 = y1 * sensor[SIM_S_TIME_Y];
  *first = sensor[SIM_S_TIME_C] + VMIN(tx0, tx1) + VMIN(ty0, ty1);
  *last = sensor[SIM_S_TIME_C] + VMAX(tx0, tx1) + VMAX(ty0, ty1);
#else
  const F x0 = (F)sensor[SIM_S_TILE_X0];
  const F x1 = (F)sensor[SIM_S_TILE_X1];
  const F from = whole ? x0 : VMIN(VMAX(extent->mean_x - extent->half_x, x0), x1);
  const F to = whole ? x1 : VMIN(VMAX(extent->mean_x + extent->half_x, x0), x1);
  const real spread = sensor[SIM_S_TIME_SPREAD] + R(2e-6);  // below 1e-6 the host counts it as none
  *first = fma(from, (F)sensor[SIM_S_INV_SPAN], (F)(sensor[SIM_S_TIME_FIRST] - spread));
  *last = fma(to, (F)sensor[SIM_S_INV_SPAN], (F)(sensor[SIM_S_TIME_FIRST] + spread));
#endif
}

/// How far ray origins may be from o_ref, m.
FN F origin_reach(const FrameParams* frame, __global const real* sensor) {
  F reach = (F)sensor[SIM_S_LEVER] + fabs(sensor[SIM_S_HEIGHT_REF]);
#if MOVING
  F first, last;
  const Extent none = {(F)R(0.0), (F)R(0.0), (F)R(0.0), (F)R(0.0)};
  times_within(frame, sensor, &none, 1, &first, &last);
  const F dt = VMAX(fabs(first - R(0.5)), fabs(last - R(0.5)));
  reach += dt * (fabs(sensor[SIM_S_CENTRE_STEP]) + fabs(sensor[SIM_S_CENTRE_STEP + 1]) +
                 fabs(sensor[SIM_S_CENTRE_STEP + 2]));
#endif
  return reach;
}

/// Bounds outside of which no ray gets alpha >= alpha_cut. Time is narrowed down from above: all rays that can
/// see the particle are in the extent of the whole frame, hence within its times; as seen in these times alone
/// they are in a smaller extent, and so forth.
FN void exact_bounds(const FrameParams* frame,
                     __global const real* sensor,
                     const Gaussian* g,
                     F reach,
                     F radius,
                     Bounds* out) {
  const Extent none = {(F)R(0.0), (F)R(0.0), (F)R(0.0), (F)R(0.0)};
  Extent whole, place[2];
  F first, last;
  times_within(frame, sensor, &none, 1, &first, &last);
  const real period = sensor[SIM_S_PERIOD];
  extent_during(sensor, g, reach, radius, first, last, (F)(R(0.5) * period), &whole);
  place[0] = place[1] = whole;
#if SENSOR == SENSOR_LIDAR
  // In [0, period] there is at most this second place, half a turn being the widest that is no full one.
  place[1].mean_x += SEL(whole.mean_x < R(0.5) * period, (F)period, (F)-period);
  const F swept_first = (F)sensor[SIM_S_TILE_X0];
  const F swept_last = (F)sensor[SIM_S_TILE_X1];
  const I both =
      AND(place[1].mean_x + place[1].half_x >= swept_first, place[1].mean_x - place[1].half_x <= swept_last);
#endif
#if MOVING
#if SENSOR == SENSOR_LIDAR
  const int places = ANY(both) ? 2 : 1;
#else
  const int places = 1;
#endif
  for (int k = 0; k < places; ++k) {
    for (int round = 1; round < EXACT_ROUNDS; ++round) {
      times_within(frame, sensor, place + k, 0, &first, &last);
      extent_during(sensor, g, reach, radius, first, last, place[k].mean_x, place + k);
    }
  }
#endif
#if SENSOR == SENSOR_CAMERA
  // Exposed at the same time: the same once more.
  place[1] = place[0];
#if WRAPS
  place[1].mean_x += SEL(place[0].mean_x < R(0.5) * period, (F)period, (F)-period);
#endif
#endif
  out->low = place[0].low;
  out->high = place[0].high;
  out->mean_x = place[0].mean_x;
  out->half_x = place[0].half_x;
  out->other_x = place[1].mean_x;
#if SENSOR == SENSOR_LIDAR
  out->other_x = SEL(both, out->other_x, out->mean_x);
  out->low = SEL(both, VMIN(out->low, place[1].low), out->low);
  out->high = SEL(both, VMAX(out->high, place[1].high), out->high);
  out->half_x = SEL(both, VMAX(out->half_x, place[1].half_x), out->half_x);
  // Half the way round is all round: narrower boxes are told apart by the nearer of their places.
  out->half_x = SEL(out->half_x > R(1.5), (F)NO_BOUND, out->half_x);
#elif WRAPS
  const real widest = min(R(0.25) * period, R(0.5) * period - SIM_SLOT_ROW);
  out->half_x = SEL(out->half_x > widest, (F)NO_BOUND, out->half_x);
#endif
}

#endif

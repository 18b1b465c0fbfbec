// lens_extent.h - picture bounds of the cutoff ellipsoid seen through a distorted lens, from bounds of the
// lens's derivatives that the host computed (lens_slope, lens_bend).
#ifndef SIMULI_CL_MATH_LENS_EXTENT_H
#define SIMULI_CL_MATH_LENS_EXTENT_H
#include "math/ellipsoid.h"

#if SENSOR == SENSOR_CAMERA && LENS != SIM_LENS_PINHOLE && !WRAPS
// Step of the differences that give the lens's derivative: the bound includes the curvature error, and pixel
// rounding divided by the step is within PAD_SHARE.
#define LENS_STEP R(1e-3)
#define LENS_CAP_MAX R(0.7)  // rad: beyond, curvature exceeds the linear term

/// Two directions across the unit vector n (Duff et al. 2017).
FN void across(const F* n, F* e1, F* e2) {
  const F sign = SEL(n[2] < R(0.0), (F)R(-1.0), (F)R(1.0));
  const F share = R(-1.0) / (sign + n[2]);
  const F mixed_xy = n[0] * n[1] * share;
  e1[0] = fma(sign * n[0], n[0] * share, (F)R(1.0));
  e1[1] = sign * mixed_xy;
  e1[2] = -sign * n[0];
  e2[0] = mixed_xy;
  e2[1] = fma(n[1], n[1] * share, sign);
  e2[2] = -n[1];
}

/// Half opening angle of the circular cone about the line of sight that contains the ellipsoid; false where the
/// ellipsoid is not in front. l, a1, a2: the axes along the line of sight, `distance` long, and in two
/// directions across.
FN I cap_angle(const Ellipsoid* e, F distance, const F* l, const F* a1, const F* a2, F* angle) {
  F along = (F)R(0.0), m1 = along, m2 = along, w11 = along, w12 = along, w22 = along;
  SIM_EACH(k, 3) {
    along = fma(l[k], l[k], along);
    m1 = fma(l[k], a1[k], m1);
    m2 = fma(l[k], a2[k], m2);
    w11 = fma(a1[k], a1[k], w11);
    w12 = fma(a1[k], a2[k], w12);
    w22 = fma(a2[k], a2[k], w22);
  }
  // Every slope is at most that of the largest moments.
  const F apart = R(0.5) * (w11 - w22);
  const F widest = R(0.5) * (w11 + w22) + sqrt(fma(apart, apart, w12 * w12));
  F low, high;
  const I outside = tangent_slopes(distance * distance,
                                   fma(e->share, along, e->more),
                                   e->share * sqrt(fma(m1, m1, m2 * m2)),
                                   fma(e->share, widest, e->more),
                                   &low,
                                   &high);
  *angle = atan2_lanes(VMAX(-low, high), (F)R(1.0));
  return outside;
}

/// Bounds one image coordinate over the cap: its derivative (d1, d2) at the centre times the ellipsoid's slopes
/// in that direction, plus at most bend / 2 times the squared angle. Angles are smaller than slopes, their
/// tangents, so the product is a bound. Tightens [low, high] where `tame`.
FN void lens_bounds(const Ellipsoid* e,
                    F distance,
                    const F* l,
                    const F* a1,
                    const F* a2,
                    F at,
                    F d1,
                    F d2,
                    F cap,
                    real bend,
                    I tame,
                    F* low,
                    F* high) {
  const F slope = sqrt(fma(d1, d1, d2 * d2));
  const I steep = slope > R(0.0);
  const F inv = R(1.0) / SEL(steep, slope, (F)R(1.0));
  F across_axes[3];
  SIM_EACH(k, 3) across_axes[k] = fma(d1, a1[k], d2 * a2[k]) * inv;
  F right, left;
  const I outside = shadow_slopes(e, distance, (F)R(0.0), l, across_axes, &right, &left);
  // The derivative itself has an error of at most bend / 2 * LENS_STEP along each direction.
  const F off = bend * cap * fma((F)R(0.5), cap, (F)LENS_STEP);
  const I tighter = AND(tame, outside);
  *low = SEL(tighter, VMAX(*low, fma(slope, right, at) - off), *low);
  *high = SEL(tighter, VMIN(*high, fma(slope, left, at) + off), *high);
}

/// Image of the unit vector n + step * across.
FN void image_beside(
    __global const SensorConstants* sensor, const F* n, const F* side, real step, F* x, F* y) {
  I shown = n[0] == n[0];
  const F q[3] = {fma(side[0], (F)step, n[0]), fma(side[1], (F)step, n[1]), fma(side[2], (F)step, n[2])};
  project_point(sensor, q, x, y, &shown);
}

/// Image bounds of directions within `cap` rad of the unit vector n, moved to the nearest direction in the
/// cone, for lanes that are `bounded`. No image moves faster than the largest px per rad that the host found in
/// the cone. A cone of at most 90 degrees is convex: its directions are nearer to the cone's nearest direction
/// than to the centre. A wider cone must contain the cap, or the bound is the whole picture.
FN void cap_extent(__global const SensorConstants* sensor,
                   F cap,
                   I bounded,
                   F off_axis,
                   F* n,
                   F* x,
                   F* y,
                   F* x0,
                   F* x1,
                   F* y0,
                   F* y1) {
  const real cone = sensor->model.lens_cone;
  if (cone > HALF_PI_R) {
    bounded = AND(bounded, off_axis + cap <= cone);
  } else {
    const F flat = sqrt(fma(n[0], n[0], n[1] * n[1]));
    const I beyond = off_axis > cone;
    const F scale = sin(cone) / SEL(flat > R(0.0), flat, (F)R(1.0));
    n[0] = SEL(beyond, n[0] * scale, n[0]);
    n[1] = SEL(beyond, n[1] * scale, n[1]);
    n[2] = SEL(beyond, (F)cos(cone), n[2]);
  }
  // The cone bounds the rays' pixels even where this direction has no image or lies beyond a fold.
  I shown = bounded;
  project_point(sensor, n, x, y, &shown);
  const F half_x = cap * sensor->model.lens_slope[0];
  const F half_y = cap * sensor->model.lens_slope[1];
  *x0 = SEL(bounded, *x - half_x, (F)-NO_BOUND);
  *x1 = SEL(bounded, *x + half_x, (F)NO_BOUND);
  *y0 = SEL(bounded, *y - half_y, (F)-NO_BOUND);
  *y1 = SEL(bounded, *y + half_y, (F)NO_BOUND);
}

/// Image bounds of a ball about p.
FN void ball_image(__global const SensorConstants* sensor, const F* p, F ball, F* x0, F* x1, F* y0, F* y1) {
  const F distance2 = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
  const F inv = R(1.0) / VMAX(sqrt(distance2), (F)R(1e-18));
  F n[3] = {p[0] * inv, p[1] * inv, p[2] * inv};
  const F slope = ball_slope(distance2, ball);
  const F off_axis = atan2_lanes(sqrt(fma(n[0], n[0], n[1] * n[1])), n[2]);
  F x, y;
  cap_extent(sensor, slope, slope < R(1.0), off_axis, n, &x, &y, x0, x1, y0, y1);
}

/// Image bounds of the ellipsoid; small caps within the cone are also bounded by the lens's derivative and
/// curvature.
FN void lens_extent(__global const SensorConstants* sensor, const Ellipsoid* e, F* x0, F* x1, F* y0, F* y1) {
  const F distance = sqrt(e->p[0] * e->p[0] + e->p[1] * e->p[1] + e->p[2] * e->p[2]);
  const F inv = R(1.0) / VMAX(distance, (F)R(1e-18));
  F n[3] = {e->p[0] * inv, e->p[1] * inv, e->p[2] * inv};
  F e1[3], e2[3], l[3], a1[3], a2[3], cap;
  across(n, e1, e2);
  SIM_EACH(k, 3) {
    l[k] = n[0] * e->a[0][k] + n[1] * e->a[1][k] + n[2] * e->a[2][k];
    a1[k] = e1[0] * e->a[0][k] + e1[1] * e->a[1][k] + e1[2] * e->a[2][k];
    a2[k] = e2[0] * e->a[0][k] + e2[1] * e->a[1][k] + e2[2] * e->a[2][k];
  }
  const I bounded = cap_angle(e, distance, l, a1, a2, &cap);
  const F off_axis = atan2_lanes(sqrt(fma(n[0], n[0], n[1] * n[1])), n[2]);
  const I tame =
      AND(bounded, AND(off_axis + cap + R(2.0) * LENS_STEP <= sensor->model.lens_cone, cap < LENS_CAP_MAX));
  F x, y;
  cap_extent(sensor, cap, bounded, off_axis, n, &x, &y, x0, x1, y0, y1);
  if (!ANY(tame)) return;
  F xa, ya, xb, yb, xc, yc, xd, yd;
  image_beside(sensor, n, e1, LENS_STEP, &xa, &ya);
  image_beside(sensor, n, e1, -LENS_STEP, &xb, &yb);
  image_beside(sensor, n, e2, LENS_STEP, &xc, &yc);
  image_beside(sensor, n, e2, -LENS_STEP, &xd, &yd);
  const real per_step = R(0.5) / LENS_STEP;
  const real bend_x = sensor->model.lens_bend[0], bend_y = sensor->model.lens_bend[1];
  lens_bounds(
      e, distance, l, a1, a2, x, (xa - xb) * per_step, (xc - xd) * per_step, cap, bend_x, tame, x0, x1);
  lens_bounds(
      e, distance, l, a1, a2, y, (ya - yb) * per_step, (yc - yd) * per_step, cap, bend_y, tame, y0, y1);
}
#endif

#endif

// extent.h - exact bounds of a particle on the sensor: extent = exact (METHOD section 4). Bounds of the cutoff
// ellipsoid (ellipsoid.h) in pixels or in spin angle and elevation, conservative.
#ifndef SIMULI_CL_MATH_EXTENT_H
#define SIMULI_CL_MATH_EXTENT_H
#include "math/lens_extent.h"

#define EXTENT_UNSCENTED 0
#define EXTENT_EXACT 1
#ifndef EXTENT
#define EXTENT EXTENT_EXACT
#endif

// Margin for float rounding added to the mathematical bounds (share of the half width, px, rad).
#define PAD_SHARE R(1e-3)
#define PAD_PX R(0.02)
#define PAD_RAD R(3e-6)

/// Bounds of a particle on the sensor, px or rad: x within half_x of either position, y in [low, high]. Where x is
/// periodic, a particle has two positions: at the cut of a sweep it is visible from the pose at the start and from
/// the pose at the end (the unrolled spin angle of METHOD section 3).
typedef struct {
  F mean_x, other_x, half_x;  // other_x differs from mean_x only where x is periodic
  F low, high;
} Bounds;

/// Bounds of one of the two positions, pixels or rad.
typedef struct {
  F mean_x, half_x, low, high;
} Extent;

#if SENSOR == SENSOR_CAMERA
/// Clips pixel bounds to slightly more than the picture, because a distant end would lose the precision of the
/// near one.
FN void picture_extent(__global const SensorConstants* sensor, F x0, F x1, F y0, F y1, Extent* out) {
  const real width = sensor->model.picture_width + R(1.0), height = sensor->model.picture_height + R(1.0);
  const F pad_x = fma((F)PAD_SHARE, x1 - x0, (F)PAD_PX), pad_y = fma((F)PAD_SHARE, y1 - y0, (F)PAD_PX);
  x0 = VMIN(VMAX(x0 - pad_x, (F)R(-1.0)), (F)width);
  x1 = VMIN(VMAX(x1 + pad_x, (F)R(-1.0)), (F)width);
  out->mean_x = R(0.5) * (x0 + x1);
  out->half_x = R(0.5) * (x1 - x0);
  out->low = VMIN(VMAX(y0 - pad_y, (F)R(-1.0)), (F)height);
  out->high = VMIN(VMAX(y1 + pad_y, (F)R(-1.0)), (F)height);
}
#endif

/// Bounds of all positions at which rays with times in [first, last] see the particle; x near `anchor` where
/// periodic.
FN void extent_during(__global const SensorConstants* sensor,
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
  const F x = (azimuth - sensor->model.azimuth_cut) * sensor->model.spin;
  const real scale = sensor->model.spin;
  const F pad = (F)PAD_RAD, pad_y = PAD_RAD + sensor->model.row_spread + PAD_SHARE * (out->high - out->low);
#else
  spherical_extent(&e, 2, 0, 1, &azimuth, &from, &to, &out->low, &out->high);
  const F x = fma(azimuth, (F)sensor->model.fx, (F)sensor->model.cx);
  out->low = fma(out->low, (F)sensor->model.fy, (F)sensor->model.cy);
  out->high = fma(out->high, (F)sensor->model.fy, (F)sensor->model.cy);
  const real scale = sensor->model.fx;
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
  x0 = fma(x0, (F)sensor->model.fx, (F)sensor->model.cx);
  x1 = fma(x1, (F)sensor->model.fx, (F)sensor->model.cx);
  y0 = fma(y0, (F)sensor->model.fy, (F)sensor->model.cy);
  y1 = fma(y1, (F)sensor->model.fy, (F)sensor->model.cy);
#else
  lens_extent(sensor, &e, &x0, &x1, &y0, &y1);
#endif
  picture_extent(sensor, x0, x1, y0, y1, out);
#endif
}

#if MOVING
/// Bounds of a ball around the particle for rays with times in [first, last]: wider than extent_during() but
/// much cheaper, enough to narrow the times. LiDAR: only x; pictures: only the coordinates that times depend
/// on.
FN void ball_during(__global const SensorConstants* sensor,
                    const Gaussian* g,
                    F radius,
                    F first,
                    F last,
                    F anchor,
                    Extent* out) {
  F p[3];
  sensor_from_particle_point(sensor, g, g->offset, R(0.5) * (first + last), p);
  const F distance2 = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
  const F ball = radius + shift_within(sensor, g, radius, sqrt(distance2), first, last);
  p[2] -= sensor->model.height;
#if SENSOR == SENSOR_LIDAR
  const F x = (atan2_lanes(p[1], p[0]) - sensor->model.azimuth_cut) * sensor->model.spin;
  out->mean_x = unrolled(sensor, x, anchor);
  out->half_x = fma(ball_slope(fma(p[0], p[0], p[1] * p[1]), ball), (F)(R(1.0) + PAD_SHARE), (F)PAD_RAD);
  out->low = out->high = (F)R(0.0);
#else
  F x0 = (F)R(0.0), x1 = x0, y0, y1;
#if WRAPS
  // x does not determine times; where the picture is periodic the anchor's period applies.
  const F slope = ball_slope(distance2, ball);
  const F elevation = atan2_lanes(p[1], sqrt(fma(p[0], p[0], p[2] * p[2])));
  y0 = fma(elevation - slope, (F)sensor->model.fy, (F)sensor->model.cy);
  y1 = fma(elevation + slope, (F)sensor->model.fy, (F)sensor->model.cy);
#elif LENS == SIM_LENS_PINHOLE
  if (sensor->model.time_x != R(0.0)) {
    const F slope = ball_slope(fma(p[2], p[2], p[0] * p[0]), ball);
    slope_ratios(p[2], p[0], slope < (F)NO_BOUND, -slope, slope, &x0, &x1);
    x0 = fma(x0, (F)sensor->model.fx, (F)sensor->model.cx);
    x1 = fma(x1, (F)sensor->model.fx, (F)sensor->model.cx);
  }
  const F slope = ball_slope(fma(p[2], p[2], p[1] * p[1]), ball);
  slope_ratios(p[2], p[1], slope < (F)NO_BOUND, -slope, slope, &y0, &y1);
  y0 = fma(y0, (F)sensor->model.fy, (F)sensor->model.cy);
  y1 = fma(y1, (F)sensor->model.fy, (F)sensor->model.cy);
#else
  ball_image(sensor, p, ball, &x0, &x1, &y0, &y1);
#endif
  picture_extent(sensor, x0, x1, y0, y1, out);
#if WRAPS
  out->mean_x = anchor;
#endif
#endif
}
#endif

/// Times of all rays with positions inside the extent; with `whole` the times of all rays.
FN void times_within(const FrameParams* frame,
                     __global const SensorConstants* sensor,
                     const Extent* extent,
                     int whole,
                     F* first,
                     F* last) {
#if SENSOR == SENSOR_CAMERA
  const real width = sensor->model.picture_width, height = sensor->model.picture_height;
  const F x0 = whole || WRAPS ? (F)R(0.0) : VMIN(VMAX(extent->mean_x - extent->half_x, (F)R(0.0)), (F)width);
  const F x1 = whole || WRAPS ? (F)width : VMIN(VMAX(extent->mean_x + extent->half_x, (F)R(0.0)), (F)width);
  const F y0 = whole ? (F)R(0.0) : VMIN(VMAX(extent->low, (F)R(0.0)), (F)height);
  const F y1 = whole ? (F)height : VMIN(VMAX(extent->high, (F)R(0.0)), (F)height);
  const F tx0 = x0 * sensor->model.time_x, tx1 = x1 * sensor->model.time_x;
  const F ty0 = y0 * sensor->model.time_y, ty1 = y1 * sensor->model.time_y;
  *first = sensor->model.time_c + VMIN(tx0, tx1) + VMIN(ty0, ty1);
  *last = sensor->model.time_c + VMAX(tx0, tx1) + VMAX(ty0, ty1);
#else
  const F x0 = (F)sensor->model.tile_first;
  const F x1 = (F)sensor->model.tile_last;
  const F from = whole ? x0 : VMIN(VMAX(extent->mean_x - extent->half_x, x0), x1);
  const F to = whole ? x1 : VMIN(VMAX(extent->mean_x + extent->half_x, x0), x1);
  const real spread = sensor->model.time_spread + R(2e-6);  // the host treats values below 1e-6 as zero
  *first = fma(from, (F)sensor->model.inv_span, (F)(sensor->model.time_first - spread));
  *last = fma(to, (F)sensor->model.inv_span, (F)(sensor->model.time_first + spread));
#endif
}

/// Largest distance in m of ray origins from o_ref.
FN F origin_reach(const FrameParams* frame, __global const SensorConstants* sensor) {
  F reach = (F)sensor->model.lever + fabs(sensor->model.height);
#if MOVING
  F first, last;
  const Extent none = {(F)R(0.0), (F)R(0.0), (F)R(0.0), (F)R(0.0)};
  times_within(frame, sensor, &none, 1, &first, &last);
  const F dt = VMAX(fabs(first - R(0.5)), fabs(last - R(0.5)));
  reach += dt * (fabs(sensor->centre_step[0]) + fabs(sensor->centre_step[1]) + fabs(sensor->centre_step[2]));
#endif
  return reach;
}

#if SENSOR == SENSOR_LIDAR
/// Whether the sweep covers part of the extent.
FN I swept(__global const SensorConstants* sensor, const Extent* extent) {
  return AND(extent->mean_x + extent->half_x >= sensor->model.tile_first,
             extent->mean_x - extent->half_x <= sensor->model.tile_last);
}
#endif

/// Bounds outside of which no ray has alpha >= alpha_cut. Times are narrowed iteratively: all rays that can see
/// the particle are in the extent of the whole frame, hence within its times; restricted to these times they
/// are in a smaller extent, and so on. All iterations but the last use a ball.
FN void exact_bounds(const FrameParams* frame,
                     __global const SensorConstants* sensor,
                     const Gaussian* g,
                     F reach,
                     F radius,
                     Bounds* out) {
  const Extent none = {(F)R(0.0), (F)R(0.0), (F)R(0.0), (F)R(0.0)};
  Extent one, other;  // for both positions; not an array, which GPUs would index in memory
  F first, last;
  times_within(frame, sensor, &none, 1, &first, &last);
  const real period = sensor->model.period;
#if MOVING && !ACTOR_MOTION  // a third viewpoint for moving actors exceeds the registers of Intel's GPUs
  ball_during(sensor, g, radius, first, last, (F)(R(0.5) * period), &one);
#else
  extent_during(sensor, g, reach, radius, first, last, (F)(R(0.5) * period), &one);
#endif
  other = one;
#if SENSOR == SENSOR_LIDAR
  // Within [0, period] this is the only second position; extents are at most half a period wide or a full one.
  other.mean_x += SEL(one.mean_x < R(0.5) * period, (F)period, (F)-period);
  I both = swept(sensor, &other);
#endif
#if MOVING
#if SENSOR == SENSOR_LIDAR
  const int places = ANY(both) ? 2 : 1;
#else
  const int places = 1;
#endif
  for (int k = 0; k < places; ++k) {
    Extent here = k == 0 ? one : other;
    times_within(frame, sensor, &here, 0, &first, &last);
    ball_during(sensor, g, radius, first, last, here.mean_x, &here);
    times_within(frame, sensor, &here, 0, &first, &last);
    extent_during(sensor, g, reach, radius, first, last, here.mean_x, &here);
    if (k == 0) {
      one = here;
    } else {
      other = here;
    }
  }
#if SENSOR == SENSOR_LIDAR
  both = AND(both, swept(sensor, &other));
#endif
#endif
#if SENSOR == SENSOR_CAMERA
  // Same exposure time, same extent.
  other = one;
#if WRAPS
  other.mean_x += SEL(one.mean_x < R(0.5) * period, (F)period, (F)-period);
#endif
#endif
  out->low = one.low;
  out->high = one.high;
  out->mean_x = one.mean_x;
  out->half_x = one.half_x;
  out->other_x = other.mean_x;
#if SENSOR == SENSOR_LIDAR
  out->other_x = SEL(both, out->other_x, out->mean_x);
  out->low = SEL(both, VMIN(out->low, other.low), out->low);
  out->high = SEL(both, VMAX(out->high, other.high), out->high);
  out->half_x = SEL(both, VMAX(out->half_x, other.half_x), out->half_x);
  // More than half a period counts as the full period; for narrower boxes the nearer of both positions applies.
  out->half_x = SEL(out->half_x > R(1.5), (F)NO_BOUND, out->half_x);
#elif WRAPS
  const real widest = min(R(0.25) * period, R(0.5) * period - SIM_TILE_SIDE);
  out->half_x = SEL(out->half_x > widest, (F)NO_BOUND, out->half_x);
#endif
}

#endif

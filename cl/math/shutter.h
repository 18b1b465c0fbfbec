// shutter.h - the time at which a moving sensor sees a point: the fixed point t = time_of(project(p, pose(t)))
// of METHOD section 3, and a bound on the derivative of its right side.
#ifndef SIMULI_CL_MATH_SHUTTER_H
#define SIMULI_CL_MATH_SHUTTER_H
#include "math/carry.h"

#ifndef SHUTTER_ITERATIONS
#define SHUTTER_ITERATIONS 4
#endif
// Convergence threshold: share of a row or column time between the assumed and the observed time.
#define SHUTTER_SETTLED R(0.03125)
// Below this rate there is exactly one solution, and images are within 3 SHUTTER_SETTLED of it.
#define SHUTTER_RATE_MAX R(0.75)
#define NO_BOUND R(1e9)  // px, rad, or a rate

/// Shifts x by periods to the value nearest to `anchor`, for sensors with periodic x.
FN F unrolled(__global const SensorConstants* sensor, F x, F anchor) {
#if WRAPS
  return anchor + wrap_lanes(x - anchor, sensor->model.period);
#else
  return x;
#endif
}

/// Image, at its own time, of the point of particle g that is at o_ref + p at mid-frame, with x unrolled near
/// the anchor; the iteration starts at time t. `valid` is cleared in lanes where the point has no image or
/// SHUTTER_ITERATIONS iterations do not converge. A converged lane stays fixed, so that results do not depend
/// on other lanes.
FN void project_at_own_time(__global const SensorConstants* sensor,
                            const Gaussian* g,
                            const F* p,
                            F anchor,
                            F t,
                            F* x,
                            F* y,
                            I* valid) {
  F q[3];
#if MOVING
  const real tolerance = SHUTTER_SETTLED * sensor->model.time_step;
  F last_t = t, last_gap = (F)R(0.0);
  I seen, settled;
  for (int k = 0; k < SHUTTER_ITERATIONS; ++k) {
    seen = *valid;
    sensor_from_particle_point(sensor, g, p, t, q);
    project_point(sensor, q, x, y, &seen);
    *x = unrolled(sensor, *x, anchor);
    const F gap = time_of(sensor, *x, *y) - t;
    settled = fabs(gap) <= tolerance;
    if (!ANY(AND(*valid, NOT(settled)))) break;
    // The first step is a fixed-point step, later ones are secant steps; secants must not diverge where the
    // rate is too high for them.
    const F dt = t - last_t;
    const F slope = (gap - last_gap) / SEL(dt != R(0.0), dt, (F)R(1.0));
    const I steady = AND(dt != R(0.0), AND(slope > R(-2.0), slope < R(-0.125)));
    F next = t + SEL(steady, -gap / SEL(steady, slope, (F)R(1.0)), gap);
    next = VMAX(VMIN(next, (F)R(1.0)), (F)R(0.0));
    last_t = t;
    last_gap = gap;
    t = SEL(settled, t, next);
  }
  *valid = AND(seen, settled);
#else
  sensor_from_particle_point(sensor, g, p, t, q);
  project_point(sensor, q, x, y, valid);
  *x = unrolled(sensor, *x, anchor);
#endif
}

#if MOVING
/// Bound on |d time_of / dt| of every point of particle g within `radius` of its centre, which is at `centre`
/// at distance `range` in the sensor frame at mid-frame (of a LiDAR relative to its reference height), with
/// times as shares of the frame. NO_BOUND or more where the points come too near or leave the cone in which the
/// lens's slopes are known.
FN F shutter_rate(
    __global const SensorConstants* sensor, const Gaussian* g, const F* centre, F range, F radius) {
  const real angle = sensor->turn_angle;
  const F step = centre_path(sensor) + carried(g, radius);
  const F ball = radius + R(0.5) * step;  // of all positions, seen from the mid-frame pose
#if SENSOR == SENSOR_CAMERA
  const F nearest = range - ball;
  const I apart = nearest > R(1e-3) * range;
  // Change in rad per frame of the direction to a point.
  const F turn = angle + step / SEL(apart, nearest, (F)R(1.0));
#endif
#if WRAPS
#if SENSOR == SENSOR_CAMERA
  const F a = centre[2], b = centre[0];
  const real by_azimuth = fabs(sensor->model.time_x) * sensor->model.fx;
  const F by_elevation = fabs(sensor->model.time_y) * sensor->model.fy * SEL(apart, turn, (F)NO_BOUND);
#else
  const F a = centre[0], b = centre[1];
  const real by_azimuth = sensor->model.inv_span;
  const F by_elevation = (F)R(0.0);
#endif
  // Azimuth changes as fast as by the same motion at the smallest distance from the axis.
  const F flat = sqrt(fma(a, a, b * b)) - ball - R(0.5) * angle * range;
  const I aside = flat > R(1e-3) * range;
  const F around = (angle * (range + ball) + step) / SEL(aside, flat, (F)R(1.0));
  return fma((F)by_azimuth, SEL(aside, around, (F)NO_BOUND), by_elevation);
#else
  // Smallest cosine to the axis of any of the points during the frame.
  const F tangent2 = fma(range, range, -(ball * ball));
  const F off = ball / sqrt(SEL(apart, tangent2, (F)R(1.0))) + R(0.5) * angle;
  const F cosine = centre[2] / range - off;
#if LENS == SIM_LENS_PINHOLE
  const I known = AND(apart, cosine > R(0.1));
  const F scale = R(1.0) / SEL(known, cosine * cosine, (F)R(1.0));
  const F slope =
      scale * (fabs(sensor->model.time_x) * sensor->model.fx + fabs(sensor->model.time_y) * sensor->model.fy);
#else
  const I known = AND(apart, cosine >= cos(sensor->model.lens_cone));
  const F slope = (F)(fabs(sensor->model.time_x) * sensor->model.lens_slope[0] +
                      fabs(sensor->model.time_y) * sensor->model.lens_slope[1]);
#endif
  return SEL(slope > R(0.0), SEL(known, slope * turn, (F)NO_BOUND), (F)R(0.0));
#endif
}
#endif

#endif

// unscented.h - extent = unscented: a particle's box from mean and covariance of its projection (METHOD section 4).
// PROJECTION_UNSCENTED: seven sigma points, alpha = 1, beta = 2, kappa = 0, hence lambda = 0: mu and mu +-
// sqrt(3) s^ e, mean weights 0 and 1/6, covariance weights 2 and 1/6. PROJECTION_LINEARIZED: the derivative at
// the centre. PROJECTION_MONTE_CARLO: SIM_MONTE_CARLO normal samples, the same for every particle. Sums use
// offsets from the projected centre, never raw coordinates.
#ifndef SIMULI_CL_PAPER_UNSCENTED_H
#define SIMULI_CL_PAPER_UNSCENTED_H
#include "math/extent.h"

#define PROJECTION_UNSCENTED 0
#define PROJECTION_LINEARIZED 1
#define PROJECTION_MONTE_CARLO 2
#ifndef PROJECTION
#define PROJECTION PROJECTION_UNSCENTED
#endif

// Within this angle (rad) of the azimuth axis particles cover all azimuths.
#define POLE_MARGIN R(0.05)

typedef struct {
  F mean_x, mean_y;  // pixels or rad
  F half_x, half_y;
  I valid;  // every projected point has an image at a time of its own
} Box;

/// offset + rotation (z * filtered scale): the point z standard deviations from the centre.
FN void point_at(const Gaussian* g, F z0, F z1, F z2, F* p) {
  const F a = z0 * g->filtered[0], b = z1 * g->filtered[1], c = z2 * g->filtered[2];
  SIM_EACH(k, 3) {
    const F* row = g->rotation + 3 * k;
    p[k] = fma(row[0], a, fma(row[1], b, fma(row[2], c, g->offset[k])));
  }
}

/// Box around the particle's position near `anchor`; the shutter iteration starts at time t. reach: radius in
/// standard deviations at which alpha falls to the cut. Invisible lanes become invalid.
FN void projected_box(__global const SensorConstants* sensor,
                      __global const real* normal_samples,
                      const Gaussian* g,
                      F reach,
                      I visible,
                      F anchor,
                      F t,
                      Box* box) {
  F x0, y0;
  I valid = visible;
  project_at_own_time(sensor, g, g->offset, anchor, t, &x0, &y0, &valid);
  const F t0 = time_of(sensor, x0, y0);
  F mean_x = (F)R(0.0), mean_y = (F)R(0.0), var_x = (F)R(0.0), var_y = (F)R(0.0);
#if PROJECTION == PROJECTION_MONTE_CARLO
  __global const real* sample = normal_samples;
  for (int k = 0; k < SIM_MONTE_CARLO; ++k, sample += 3) {
    F p[3], x, y;
    point_at(g, (F)sample[0], (F)sample[1], (F)sample[2], p);
    project_at_own_time(sensor, g, p, x0, t0, &x, &y, &valid);
    mean_x += x - x0;
    mean_y += y - y0;
    var_x = fma(x - x0, x - x0, var_x);
    var_y = fma(y - y0, y - y0, var_y);
  }
  const real share = R(1.0) / SIM_MONTE_CARLO;
  mean_x *= share;
  mean_y *= share;
  var_x = VMAX(fma(var_x, (F)share, -mean_x * mean_x), (F)R(0.0));
  var_y = VMAX(fma(var_y, (F)share, -mean_y * mean_y), (F)R(0.0));
#else
#if PROJECTION == PROJECTION_LINEARIZED
  const real arm = R(0.03125);  // step of central differences in standard deviations
  const real weight = R(512.0);
#else
  const real arm = R(1.7320508075688772);
  const real weight = R(0.16666666666666667);
#endif
  SIM_EACH(axis, 3) {
    F dx[2], dy[2];
    SIM_EACH(end, 2) {
      const real z = end == 0 ? arm : -arm;
      F p[3], x, y;
      point_at(g, (F)(axis == 0 ? z : R(0.0)), (F)(axis == 1 ? z : R(0.0)), (F)(axis == 2 ? z : R(0.0)), p);
      project_at_own_time(sensor, g, p, x0, t0, &x, &y, &valid);
      dx[end] = x - x0;
      dy[end] = y - y0;
    }
#if PROJECTION == PROJECTION_LINEARIZED
    // Both halves of the difference, in which the curvature cancels.
    const F slope_x = (dx[0] - dx[1]) * R(0.5), slope_y = (dy[0] - dy[1]) * R(0.5);
    var_x = fma(slope_x, slope_x * (R(2.0) * weight), var_x);
    var_y = fma(slope_y, slope_y * (R(2.0) * weight), var_y);
#else
    mean_x += dx[0] + dx[1];
    mean_y += dy[0] + dy[1];
    var_x = fma(dx[0], dx[0], fma(dx[1], dx[1], var_x));
    var_y = fma(dy[0], dy[0], fma(dy[1], dy[1], var_y));
#endif
  }
#if PROJECTION == PROJECTION_UNSCENTED
  // With md = sum d / 6: 2 md^2 + sum (d - md)^2 / 6 = md^2 + sum d^2 / 6, all terms positive.
  mean_x *= weight;
  mean_y *= weight;
  var_x = fma(mean_x, mean_x, var_x * weight);
  var_y = fma(mean_y, mean_y, var_y * weight);
#endif
#endif
  box->mean_x = x0 + mean_x;
  box->mean_y = y0 + mean_y;
  box->half_x = reach * sqrt(var_x);
  box->half_y = reach * sqrt(var_y);
  box->valid = valid;
}

#if SENSOR == SENSOR_LIDAR && MOVING
/// Raises x and y to the displacement of the centre's image from time t to t + dt.
FN void drift(__global const SensorConstants* sensor, const Gaussian* g, F t, F dt, F* x, F* y) {
  F q[3], x0, y0, x1, y1;
  I seen = t == t;
  sensor_from_particle_point(sensor, g, g->offset, t, q);
  project_point(sensor, q, &x0, &y0, &seen);
  sensor_from_particle_point(sensor, g, g->offset, t + dt, q);
  project_point(sensor, q, &x1, &y1, &seen);
  *x = VMAX(*x, fabs(wrap_lanes(x1 - x0, TWO_PI_R)));
  *y = VMAX(*y, fabs(y1 - y0));
}
#endif

/// Bounds from projected points of a particle of size `radius` at `centre` in the sensor frame at mid-frame.
/// False in lanes where these are no valid measure: a point without an image or without a time of its own, a
/// sensor too fast for a unique image, or a particle around the sensor or its axis.
#if SENSOR == SENSOR_CAMERA
FN I unscented_bounds(const FrameParams* frame,
                      __global const SensorConstants* sensor,
                      __global const real* normal_samples,
                      const Gaussian* g,
                      const F* centre,
                      F reach,
                      F radius,
                      I visible,
                      Bounds* out) {
  Box box;
  F anchor = (F)R(0.0);
#if WRAPS
  F anchor_y;
  I has_image = visible;
  project_point(sensor, centre, &anchor, &anchor_y, &has_image);
#endif
  projected_box(sensor, normal_samples, g, reach, visible, anchor, (F)R(0.5), &box);
  I known = box.valid;
#if MOVING
  known = AND(known, shutter_rate(sensor, g, centre, g->range, radius) < SHUTTER_RATE_MAX);
#endif
  out->mean_x = box.mean_x;
  out->other_x = box.mean_x;
  out->half_x = box.half_x;
#if WRAPS
  const real period = sensor->model.period;
  out->other_x += SEL(box.mean_x < R(0.5) * period, (F)period, (F)-period);
  // Near a pole of the picture a particle covers all columns.
  const F flat = sqrt(centre[0] * centre[0] + centre[2] * centre[2]);
  known = AND(known, flat > fma(fabs(centre[1]), (F)POLE_MARGIN, radius));
#if MOVING
  // Columns exposed at different times: the two ends of the picture do not show the same position.
  const I joined = AND(box.mean_x - box.half_x > R(0.0), box.mean_x + box.half_x < period);
  known = AND(known, OR(joined, (F)sensor->model.time_x == R(0.0)));
#endif
  // More than half a period counts as the full period; for narrower boxes the nearer of both positions applies.
  const real widest = min(R(0.25) * period, R(0.5) * period - SIM_TILE_SIDE);
  out->half_x = SEL(box.half_x > widest, (F)NO_BOUND, box.half_x);
#endif
  out->low = box.mean_y - box.half_y;
  out->high = box.mean_y + box.half_y;
  return known;
}
#else
FN I unscented_bounds(const FrameParams* frame,
                      __global const SensorConstants* sensor,
                      __global const real* normal_samples,
                      const Gaussian* g,
                      const F* centre,
                      F reach,
                      F radius,
                      I visible,
                      Bounds* out) {
  Box box;
  F middle_x, middle_y;
  I has_image = visible;
  project_point(sensor, centre, &middle_x, &middle_y, &has_image);
  middle_x = SEL(middle_x < R(0.0), middle_x + TWO_PI_R, middle_x);
  const F around_back = SEL(middle_x < PI_R, (F)TWO_PI_R, (F)-TWO_PI_R);
  projected_box(
      sensor, normal_samples, g, reach, visible, middle_x, time_of(sensor, middle_x, middle_y), &box);
  const F level[3] = {centre[0], centre[1], centre[2] - sensor->model.height};
  const F flat = sqrt(level[0] * level[0] + level[1] * level[1]);
  const F distance = sqrt(flat * flat + level[2] * level[2]);
  const F lever = sensor->model.lever / VMAX(distance - sensor->model.lever, (F)R(1e-3));
  const F swept_first = (F)sensor->model.tile_first;
  const F swept_last = (F)sensor->model.tile_last;
  const F other_x = middle_x + around_back;
  // For particles that the sensor passes over or under, the azimuth changes too fast for a box.
  const real passed = R(0.5) * centre_path(sensor);
  const F travel = carried(g, radius);
  I known = AND(distance > radius + R(0.5) * travel,
                flat > fma(fabs(level[2]), (F)POLE_MARGIN, radius) + passed + R(0.5) * travel);
  F drift_x = (F)R(0.0), drift_y = (F)R(0.0);
#if MOVING
  known = AND(known, shutter_rate(sensor, g, level, distance, radius) < SHUTTER_RATE_MAX);
  if (sensor->model.time_spread > R(0.0)) {
    const F t0 = time_of(sensor, box.mean_x, box.mean_y);
    const F dt = (F)sensor->model.time_spread;
    drift(sensor, g, t0, dt, &drift_x, &drift_y);
    drift(sensor, g, t0, -dt, &drift_x, &drift_y);
    // A drifting spin angle implies another time: dt / (1 - rate of drift / rate of spin).
    const F farther = dt / (R(1.0) - VMIN(drift_x * sensor->model.inv_span / dt, (F)R(0.75)));
    drift(sensor, g, t0, farther, &drift_x, &drift_y);
    drift(sensor, g, t0, -farther, &drift_x, &drift_y);
  }
#endif
  Box other = box;
  other.mean_x = other_x;
#if MOVING
  // The second position is rarely swept: evaluated only where it may be, including motion during the sweep.
  const F slack = R(2.0) * box.half_x + lever + drift_x + sensor->turn_angle + R(0.01) +
                  (fabs(sensor->centre_step[0]) + travel) / VMAX(flat, (F)R(1e-3)) +
                  fabs(sensor->centre_step[1]) / VMAX(flat, (F)R(1e-3));
  const I near = AND(visible, AND(other_x + slack >= swept_first, other_x - slack <= swept_last));
  if (ANY(near)) {
    projected_box(
        sensor, normal_samples, g, reach, near, other_x, time_of(sensor, other_x, middle_y), &other);
  }
  known = AND(known, AND(box.valid, OR(other.valid, NOT(near))));
#else
  other.mean_x = box.mean_x + around_back;
#endif
  const F wider = lever + drift_x;
  const I both = AND(other.mean_x + other.half_x + wider >= swept_first,
                     other.mean_x - other.half_x - wider <= swept_last);
  const F low = box.mean_y - box.half_y, high = box.mean_y + box.half_y;
  out->low = SEL(both, VMIN(low, other.mean_y - other.half_y), low) - lever - drift_y;
  out->high = SEL(both, VMAX(high, other.mean_y + other.half_y), high) + lever + drift_y;
  out->mean_x = box.mean_x;
  out->other_x = SEL(both, other.mean_x, box.mean_x);
  out->half_x = SEL(both, VMAX(box.half_x, other.half_x), box.half_x) + wider;
  // More than half a period counts as the full period; for narrower boxes the nearer of both positions applies.
  out->half_x = SEL(out->half_x > R(1.5), (F)NO_BOUND, out->half_x);
  return known;
}
#endif

/// Bounds as in exact_bounds(), from projected points where these are a valid measure.
FN void unscented_or_exact_bounds(const FrameParams* frame,
                                  __global const SensorConstants* sensor,
                                  __global const real* normal_samples,
                                  const Gaussian* g,
                                  const F* centre,
                                  F reach,
                                  F radius,
                                  I visible,
                                  Bounds* box) {
  const I known = unscented_bounds(frame, sensor, normal_samples, g, centre, reach, radius, visible, box);
  if (ANY(AND(visible, NOT(known)))) {
    Bounds all;
    exact_bounds(frame, sensor, g, reach, radius, &all);
    box->mean_x = SEL(known, box->mean_x, all.mean_x);
    box->other_x = SEL(known, box->other_x, all.other_x);
    box->half_x = SEL(known, box->half_x, all.half_x);
    box->low = SEL(known, box->low, all.low);
    box->high = SEL(known, box->high, all.high);
  }
}

#endif

// unscented.h - the box of a particle from the mean and covariance of its projection (METHOD section 4).
// PROJECTION_UNSCENTED: seven sigma points, alpha = 1, beta = 2, kappa = 0, hence lambda = 0: mu and mu +- sqrt(3)
// s^ e, mean weights 0 and 1/6, covariance weights 2 and 1/6. PROJECTION_LINEARIZED: the derivative at the centre.
// PROJECTION_MONTE_CARLO: SIM_MONTE_CARLO normal samples, the same for every particle. Offsets are summed from the
// projected centre, never raw coordinates.
#ifndef SIMULI_CL_MATH_UNSCENTED_H
#define SIMULI_CL_MATH_UNSCENTED_H
#include "math/gaussian.h"
#include "math/sensor.h"

#define SHUTTER_ITERATIONS 3

#define PROJECTION_UNSCENTED 0
#define PROJECTION_LINEARIZED 1
#define PROJECTION_MONTE_CARLO 2
#ifndef PROJECTION
#define PROJECTION PROJECTION_UNSCENTED
#endif

typedef struct {
  F mean_x, mean_y;  // pixels or rad
  F half_x, half_y;
  I valid;           // every projected point has an image
} Box;

/// x by the way round that is nearest to `anchor`, for sensors whose x goes round.
FN F unrolled(__global const real* sensor, F x, F anchor) {
#if WRAPS
  return anchor + wrap_lanes(x - anchor, sensor[SIM_S_PERIOD]);
#else
  return x;
#endif
}

/// Image of the world point o_ref + p at its own time: t <- time(project(p, pose(t))), from the time of
/// (anchor, y), x being unrolled near the anchor.
FN void project_at_own_time(__global const real* sensor, const F* p, F anchor, F t, F* x, F* y, I* valid) {
  F q[3];
#if MOVING
  for (int k = 0; k < SHUTTER_ITERATIONS; ++k) {
    I seen = *valid;
    sensor_from_world_point(sensor, p, t, q);
    project_point(sensor, q, x, y, &seen);
    *x = unrolled(sensor, *x, anchor);
    t = time_of(sensor, *x, *y);
  }
#endif
  sensor_from_world_point(sensor, p, t, q);
  project_point(sensor, q, x, y, valid);
  *x = unrolled(sensor, *x, anchor);
}

/// offset + rotation (z * filtered scale): the point z standard deviations off the centre.
FN void point_at(const Gaussian* g, F z0, F z1, F z2, F* p) {
  const F a = z0 * g->filtered[0], b = z1 * g->filtered[1], c = z2 * g->filtered[2];
  for (int k = 0; k < 3; ++k) {
    const F* row = g->rotation + 3 * k;
    p[k] = fma(row[0], a, fma(row[1], b, fma(row[2], c, g->offset[k])));
  }
}

/// The box about the particle's place near `anchor`, the iteration starting at time t.
/// reach: the radius in standard deviations at which alpha falls to the cut.
FN void projected_box(__global const real* sensor, const Gaussian* g, F reach, F anchor, F t, Box* box) {
  F x0, y0;
  I valid = (F)R(0.0) == (F)R(0.0);
  project_at_own_time(sensor, g->offset, anchor, t, &x0, &y0, &valid);
  const F t0 = time_of(sensor, x0, y0);
  F mean_x = (F)R(0.0), mean_y = (F)R(0.0), var_x = (F)R(0.0), var_y = (F)R(0.0);
#if PROJECTION == PROJECTION_MONTE_CARLO
  __global const real* sample = sensor + SIM_SENSOR_REALS;
  for (int k = 0; k < SIM_MONTE_CARLO; ++k, sample += 3) {
    F p[3], x, y;
    point_at(g, (F)sample[0], (F)sample[1], (F)sample[2], p);
    project_at_own_time(sensor, p, x0, t0, &x, &y, &valid);
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
  const real arm = R(0.03125);  // central differences over a small part of a standard deviation
  const real weight = R(512.0);
#else
  const real arm = R(1.7320508075688772);
  const real weight = R(0.16666666666666667);
#endif
  for (int axis = 0; axis < 3; ++axis) {
    F dx[2], dy[2];
    for (int end = 0; end < 2; ++end) {
      const real z = end == 0 ? arm : -arm;
      F p[3], x, y;
      point_at(g,
               (F)(axis == 0 ? z : R(0.0)),
               (F)(axis == 1 ? z : R(0.0)),
               (F)(axis == 2 ? z : R(0.0)),
               p);
      project_at_own_time(sensor, p, x0, t0, &x, &y, &valid);
      dx[end] = x - x0;
      dy[end] = y - y0;
    }
#if PROJECTION == PROJECTION_LINEARIZED
    // Both halves of the difference: the curvature cancels.
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

#endif

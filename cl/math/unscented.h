// unscented.h - the box of a particle by seven projected sigma points (METHOD section 4).
// alpha = 1, beta = 2, kappa = 0: lambda = 0, points at mu and mu +- sqrt(3) s^ e, mean weights 0 and 1/6,
// covariance weights 2 and 1/6. Offsets are summed from the projected centre, never raw coordinates.
#ifndef SIMULI_CL_MATH_UNSCENTED_H
#define SIMULI_CL_MATH_UNSCENTED_H
#include "math/gaussian.h"
#include "math/sensor.h"

#define SHUTTER_ITERATIONS 3

typedef struct {
  F mean_x, mean_y;  // pixels or rad
  F half_x, half_y;
  I valid;           // every sigma point has an image
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

/// The box about the particle's place near `anchor`, the iteration starting at time t.
/// reach: the radius in standard deviations at which alpha falls to the cut.
FN void unscented_box(__global const real* sensor, const Gaussian* g, F reach, F anchor, F t, Box* box) {
  F x0, y0;
  I valid = (F)R(0.0) == (F)R(0.0);
  project_at_own_time(sensor, g->offset, anchor, t, &x0, &y0, &valid);
  const F t0 = time_of(sensor, x0, y0);
  F sum_x = (F)R(0.0), sum_y = (F)R(0.0), sum_xx = (F)R(0.0), sum_yy = (F)R(0.0);
  for (int axis = 0; axis < 3; ++axis) {
    const F arm = g->filtered[axis] * R(1.7320508075688772);
    for (int end = 0; end < 2; ++end) {
      const F signed_arm = end == 0 ? arm : -arm;
      const F p[3] = {fma(g->rotation[axis], signed_arm, g->offset[0]),
                      fma(g->rotation[3 + axis], signed_arm, g->offset[1]),
                      fma(g->rotation[6 + axis], signed_arm, g->offset[2])};
      F x, y;
      project_at_own_time(sensor, p, x0, t0, &x, &y, &valid);
      const F dx = x - x0;
      const F dy = y - y0;
      sum_x += dx;
      sum_y += dy;
      sum_xx = fma(dx, dx, sum_xx);
      sum_yy = fma(dy, dy, sum_yy);
    }
  }
  // With md = sum d / 6: 2 md^2 + sum (d - md)^2 / 6 = md^2 + sum d^2 / 6, all terms positive.
  const F md_x = sum_x * R(0.16666666666666667);
  const F md_y = sum_y * R(0.16666666666666667);
  box->mean_x = x0 + md_x;
  box->mean_y = y0 + md_y;
  box->half_x = reach * sqrt(fma(md_x, md_x, sum_xx * R(0.16666666666666667)));
  box->half_y = reach * sqrt(fma(md_y, md_y, sum_yy * R(0.16666666666666667)));
  box->valid = valid;
}

#endif

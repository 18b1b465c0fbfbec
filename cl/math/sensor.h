// sensor.h - the maps point -> (x, y) -> time of cameras and LiDARs.
// Build: SENSOR = SENSOR_CAMERA or SENSOR_LIDAR.
#ifndef SIMULI_CL_MATH_SENSOR_H
#define SIMULI_CL_MATH_SENSOR_H
#include "math/camera.h"
#include "math/elementary.h"
#include "math/sensor_pose.h"
#include "shared/layout.h"
#include "shared/sensor_constants.h"

// The camera's lens: SIM_LENS_.. of shared/sensor_constants.h.
#ifndef LENS
#define LENS SIM_LENS_PINHOLE
#endif

// SIM_BEND_.. of a windshield in front of it.
#ifndef WINDSHIELD
#define WINDSHIELD SIM_BEND_NONE
#endif

// Whether x is periodic with sensor->model.period.
#if SENSOR == SENSOR_LIDAR || LENS == SIM_LENS_EQUIRECTANGULAR
#define WRAPS 1
#else
#define WRAPS 0
#endif

/// (x, y) of a sensor-frame point: pixels, or the spin angle since the sweep's start (rad, shorter direction,
/// in [-pi, pi]) and elevation (rad). `valid` is cleared in lanes without an image: nearer than 1 cm to the
/// camera or outside the lens's domain.
FN void project_point(__global const SensorConstants* sensor, const F* p, F* x, F* y, I* valid) {
#if SENSOR == SENSOR_CAMERA
  F u, v;
#if WINDSHIELD == SIM_BEND_NONE
  const F px = p[0], py = p[1], pz = p[2];
#else
  F px = p[0], py = p[1], pz = p[2];
  bend_point(&sensor->model.lens, WINDSHIELD == SIM_BEND_BACKWARD, &px, &py, &pz, valid);
#endif
#if LENS == SIM_LENS_PINHOLE
  pinhole_image(px, py, pz, &u, &v, valid);
#elif LENS == SIM_LENS_OPENCV_PINHOLE
  opencv_pinhole_image(&sensor->model.lens, px, py, pz, &u, &v, valid);
#elif LENS == SIM_LENS_OPENCV_FISHEYE
  opencv_fisheye_image(&sensor->model.lens, px, py, pz, &u, &v, valid);
#elif LENS == SIM_LENS_FTHETA
  ftheta_image(&sensor->model.lens, px, py, pz, &u, &v, valid);
#elif LENS == SIM_LENS_FTHETA_INVERSE
  ftheta_inverse_image(&sensor->model.lens, px, py, pz, &u, &v, valid);
#elif LENS == SIM_LENS_MEI
  mei_image(&sensor->model.lens, px, py, pz, &u, &v, valid);
#elif LENS == SIM_LENS_EQUIRECTANGULAR
  equirectangular_image(px, py, pz, &u, &v, valid);
#elif LENS == SIM_LENS_DOUBLE_SPHERE
  double_sphere_image(&sensor->model.lens, px, py, pz, &u, &v, valid);
#elif LENS == SIM_LENS_EUCM
  eucm_image(&sensor->model.lens, px, py, pz, &u, &v, valid);
#endif
  *x = fma(u, (F)sensor->model.fx, (F)sensor->model.cx);
  *y = fma(v, (F)sensor->model.fy, (F)sensor->model.cy);
#if WRAPS
  *x -= sensor->model.period * floor(*x / sensor->model.period);
#endif
#else
  const F z = p[2] - sensor->model.height;
  *x = wrap_lanes((atan2_lanes(p[1], p[0]) - sensor->model.azimuth_cut) * sensor->model.spin, TWO_PI_R);
  *y = atan2_lanes(z, sqrt(p[0] * p[0] + p[1] * p[1]));
#endif
}

/// Share of the frame in [0, 1] at which (x, y) is measured; x of a LiDAR is the unrolled spin angle.
FN F time_of(__global const SensorConstants* sensor, F x, F y) {
#if SENSOR == SENSOR_CAMERA
  F t = fma(x, (F)sensor->model.time_x, fma(y, (F)sensor->model.time_y, (F)sensor->model.time_c));
#else
  F t = fma(x, (F)sensor->model.inv_span, (F)sensor->model.time_first);
#endif
  t = VMIN(t, (F)R(1.0));
  return VMAX(t, (F)R(0.0));
}

/// Index of the cell that contains x, or the nearest one, of `count` cells from `first` on, `scale` per rad.
FN uint cell_of(real x, real first, real scale, real count) {
  return (uint)max(min((x - first) * scale, count - R(1.0)), R(0.0));
}

#endif

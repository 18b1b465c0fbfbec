// sensor.h - the sensor's pose at a time, and the maps point -> (x, y) -> time of cameras and LiDARs.
// Rays (rays.cl) and projection (project.cl) share these functions, so that they agree.
// Build: SENSOR = SENSOR_CAMERA or SENSOR_LIDAR, MOVING = 0 or 1.
#ifndef SIMULI_CL_MATH_SENSOR_H
#define SIMULI_CL_MATH_SENSOR_H
#include "math/camera.h"
#include "math/elementary.h"
#include "shared/layout.h"
#include "shared/sensor_constants.h"

#define SENSOR_CAMERA 0
#define SENSOR_LIDAR 1

// The camera's lens: SIM_LENS_.. of shared/sensor_constants.h.
#ifndef LENS
#define LENS SIM_LENS_PINHOLE
#endif

// SIM_BEND_.. of a windshield before it.
#ifndef WINDSHIELD
#define WINDSHIELD SIM_BEND_NONE
#endif

// Whether x comes round again after sensor->model.period.
#if SENSOR == SENSOR_LIDAR || LENS == SIM_LENS_EQUIRECTANGULAR
#define WRAPS 1
#else
#define WRAPS 0
#endif

/// v turned about the unit axis by the angle whose sine and cosine are given (Rodrigues).
FN void turn(__global const real* axis, F sine, F cosine, F* v) {
  const real ax = axis[0], ay = axis[1], az = axis[2];
  const F dot = (ax * v[0] + ay * v[1] + az * v[2]) * (R(1.0) - cosine);
  const F cx = ay * v[2] - az * v[1];
  const F cy = az * v[0] - ax * v[2];
  const F cz = ax * v[1] - ay * v[0];
  v[0] = v[0] * cosine + cx * sine + ax * dot;
  v[1] = v[1] * cosine + cy * sine + ay * dot;
  v[2] = v[2] * cosine + cz * sine + az * dot;
}

/// out = M v, or M^T v when `transposed`; M row-major 3x3.
FN void rotate(__global const real* m, const F* v, F* out) {
  out[0] = m[0] * v[0] + m[1] * v[1] + m[2] * v[2];
  out[1] = m[3] * v[0] + m[4] * v[1] + m[5] * v[2];
  out[2] = m[6] * v[0] + m[7] * v[1] + m[8] * v[2];
}
FN void rotate_back(__global const real* m, const F* v, F* out) {
  out[0] = m[0] * v[0] + m[3] * v[1] + m[6] * v[2];
  out[1] = m[1] * v[0] + m[4] * v[1] + m[7] * v[2];
  out[2] = m[2] * v[0] + m[5] * v[1] + m[8] * v[2];
}

/// How far the sensor's centre moves during the frame (m).
FN real centre_path(__global const SensorConstants* sensor) {
  return sqrt(sensor->centre_step[0] * sensor->centre_step[0] +
              sensor->centre_step[1] * sensor->centre_step[1] +
              sensor->centre_step[2] * sensor->centre_step[2]);
}

/// World direction of a sensor-frame vector at time t in [0, 1] of the frame.
FN void world_from_sensor_vector(__global const SensorConstants* sensor, const F* v, F t, F* out) {
#if MOVING
  F turned[3] = {v[0], v[1], v[2]};
  F sine, cosine;
  sincos_lanes(sensor->turn_angle * t, &sine, &cosine);
  turn(sensor->turn_axis, sine, cosine, turned);
  rotate_back(sensor->rotation_start, turned, out);
#else
  rotate_back(sensor->rotation_ref, v, out);
#endif
}

/// Sensor-frame coordinates at time t of the world point o_ref + p.
FN void sensor_from_world_point(__global const SensorConstants* sensor, const F* p, F t, F* out) {
#if MOVING
  // o_ref + p - centre(t), the centre moving evenly about o_ref.
  const F u = t - R(0.5);
  const F moved[3] = {p[0] - sensor->centre_step[0] * u,
                      p[1] - sensor->centre_step[1] * u,
                      p[2] - sensor->centre_step[2] * u};
  rotate(sensor->rotation_start, moved, out);
  F sine, cosine;
  sincos_lanes(sensor->turn_angle * t, &sine, &cosine);
  turn(sensor->turn_axis, -sine, cosine, out);
#else
  rotate(sensor->rotation_ref, p, out);
#endif
}

/// (x, y) of a sensor-frame point: pixels, or the spin angle since the sweep's start (rad, by the shorter way
/// round, in [-pi, pi]) and elevation (rad). `valid` is cleared in lanes where the point has no image: nearer
/// than 1 cm to the camera or outside the lens's domain.
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

/// Share of the frame at which (x, y) is measured, in [0, 1]; a LiDAR's x is the unrolled spin angle.
FN F time_of(__global const SensorConstants* sensor, F x, F y) {
#if SENSOR == SENSOR_CAMERA
  F t = fma(x, (F)sensor->model.time_x, fma(y, (F)sensor->model.time_y, (F)sensor->model.time_c));
#else
  F t = fma(x, (F)sensor->model.inv_span, (F)sensor->model.time_first);
#endif
  t = VMIN(t, (F)R(1.0));
  return VMAX(t, (F)R(0.0));
}

/// Of `count` cells that start at `first`, `scale` to the rad, the one that holds x, or the one nearest to it.
FN uint cell_of(real x, real first, real scale, real count) {
  return (uint)max(min((x - first) * scale, count - R(1.0)), R(0.0));
}

#endif

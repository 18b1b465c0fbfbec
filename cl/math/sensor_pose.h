// sensor_pose.h - the sensor's pose at a time. Rays (rays.cl) and projection (project.cl) share it, so that
// they agree.
// Build: MOVING = 1 when the pose changes during the frame.
#ifndef SIMULI_CL_MATH_SENSOR_POSE_H
#define SIMULI_CL_MATH_SENSOR_POSE_H
#include "math/elementary.h"
#include "shared/sensor_constants.h"

/// Rotates v about the unit axis by the angle with the given sine and cosine (Rodrigues).
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

/// Path length of the sensor's centre during the frame (m).
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
  // o_ref + p - centre(t), with the centre moving uniformly about o_ref.
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

#endif

// pose_bwd.cl - gradient of a frame's pose from those of rays and means. Launcher: host/render/backward/pose_bwd.cpp
#include "math/sensor.h"

/// A world vector in the sensor's axes at time t.
FN void sensor_from_world_vector(__global const real* sensor, const F* v, F t, F* out) {
#if MOVING
  rotate(sensor + SIM_S_ROT_START, v, out);
  F sine, cosine;
  sincos_lanes(sensor[SIM_S_ANGLE] * t, &sine, &cosine);
  turn(sensor + SIM_S_AXIS, -sine, cosine, out);
#else
  rotate(sensor + SIM_S_ROT_REF, v, out);
#endif
}

FN void add_cross(const F* a, const F* b, F* sum) {
  sum[0] += a[1] * b[2] - a[2] * b[1];
  sum[1] += a[2] * b[0] - a[0] * b[2];
  sum[2] += a[0] * b[1] - a[1] * b[0];
}

/// Turning the sensor by w in its own axes changes a ray's direction d by w x d, and its origin (from the
/// sensor's centre) alike: dL/dw = sum of d x g_d + o x g_o, all in the sensor's axes at the ray's time.
/// in  sensor_ray[3|7][slots], ray_grads[3|6][slots]: world; chunk: slots per work-item, a multiple of V
/// out sums[work-items][3]
__kernel void rays_torque(const FrameParams frame,
                          const uint chunk,
                          __global const real* sensor,
                          __global const real* sensor_ray,
                          __global const real* ray_grads,
                          __global real* sums) {
  const uint s = frame.slots;
  const uint begin = get_global_id(0) * chunk;
  const uint end = min(begin + chunk, s);
  F sum[3] = {(F)R(0.0), (F)R(0.0), (F)R(0.0)};
  for (uint i = begin; i < end; i += V) {
    F arm[3], world[3], gradient[3];
#if ORIGINS
    const F t = LDV(sensor_ray + 6 * s + i);
#else
    const F t = (F)R(0.5);
#endif
    for (int k = 0; k < 3; ++k) {
      arm[k] = LDV(sensor_ray + k * s + i);
      world[k] = LDV(ray_grads + k * s + i);
    }
    sensor_from_world_vector(sensor, world, t, gradient);
    add_cross(arm, gradient, sum);
#if ORIGINS
    for (int k = 0; k < 3; ++k) {
      arm[k] = LDV(sensor_ray + (3 + k) * s + i);
      world[k] = LDV(ray_grads + (3 + k) * s + i);
    }
    sensor_from_world_vector(sensor, world, t, gradient);
    add_cross(arm, gradient, sum);
#endif
  }
  for (int k = 0; k < 3; ++k) sums[3 * get_global_id(0) + k] = HSUM(sum[k]);
}

/// Sum of the gradients of the means that the frame did not cull.
/// in  keys[N], param_grads[rows][stride]; out sums[work-items][3]
__kernel void particles_force(const FrameParams frame,
                              const uint chunk,
                              __global const uint* keys,
                              __global const real* param_grads,
                              __global real* sums) {
  const uint begin = get_global_id(0) * chunk;
  const uint end = min(begin + chunk, frame.particles);
  real sum[3] = {R(0.0), R(0.0), R(0.0)};
  for (uint i = begin; i < end; ++i) {
    if (keys[i] == 0xffffffffu) continue;
    for (int k = 0; k < 3; ++k) {
      const real g = param_grads[(SIM_MEAN + k) * frame.stride + i];
      sum[k] += fabs(g) < R(1e30) ? g : R(0.0);
    }
  }
  for (int k = 0; k < 3; ++k) sums[3 * get_global_id(0) + k] = sum[k];
}

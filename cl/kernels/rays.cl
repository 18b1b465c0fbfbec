// rays.cl - transforms sensor rays to world rays of one frame. Launcher: host/device/render/frame/rays.cpp
#include "math/sensor_pose.h"
#include "shared/layout.h"

/// Transforms each slot's ray from the sensor frame to the world at the ray's own time. V slots per work-item.
/// Slots without a ray keep their zero direction, which hits nothing.
/// in  sensor_ray[3|7][slots]: unit direction; with ORIGINS also origin (m) and time share of the frame
/// out world_ray[3|6|7][slots]: unit direction; with ORIGINS also origin minus o_ref, m; with ACTOR_MOTION also
///     the time share
__kernel void rays(const FrameParams frame,
                   __global const SensorConstants* sensor,
                   __global const real* sensor_ray,
                   __global real* world_ray) {
  const uint i = get_global_id(0) * V;
  if (i >= frame.slots) return;
  const uint s = frame.slots;
  F d[3], world[3];
  SIM_EACH(k, 3) d[k] = LDV(sensor_ray + k * s + i);
#if ORIGINS
  F o[3];
  SIM_EACH(k, 3) o[k] = LDV(sensor_ray + (3 + k) * s + i);
  const F t = LDV(sensor_ray + 6 * s + i);
#else
  const F t = (F)R(0.5);
#endif
  world_from_sensor_vector(sensor, d, t, world);
  SIM_EACH(k, 3) STV(world_ray + k * s + i, world[k]);
#if ORIGINS
  world_from_sensor_vector(sensor, o, t, world);
  SIM_EACH(k, 3) {
#if MOVING
    world[k] += sensor->centre_step[k] * (t - R(0.5));
#endif
    STV(world_ray + (3 + k) * s + i, world[k]);
  }
#if ACTOR_MOTION
  STV(world_ray + 6 * s + i, t);
#endif
#endif
}

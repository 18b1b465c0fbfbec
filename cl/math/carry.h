// carry.h - points of particles on moving actors, in the sensor frame at a time of the frame.
#ifndef SIMULI_CL_MATH_CARRY_H
#define SIMULI_CL_MATH_CARRY_H
#include "math/gaussian.h"
#include "math/sensor.h"

/// Makes a particle that does not move, for points at rest. Not a null pointer: AMD's compiler, whose private
/// null is not 0, keeps compared pointers in memory.
FN void stand_still(Gaussian* g) {
#if ACTORS
  g->actor.any = 0;
#endif
}

/// Sensor-frame coordinates at time t of the point of particle g that is at o_ref + p at mid-frame.
FN void sensor_from_particle_point(
    __global const SensorConstants* sensor, const Gaussian* g, const F* p, F t, F* out) {
#if ACTOR_MOTION
  if (g->actor.any) {
    F turn[9], moved[3];
    actor_turn(&g->actor, t, turn);
    actor_carry(&g->actor, turn, t, p, moved);
    sensor_from_world_point(sensor, moved, t, out);
    return;
  }
#endif
  sensor_from_world_point(sensor, p, t, out);
}

/// Upper bound of the displacement in m during the frame of points within `radius` of the particle's centre.
FN F carried(const Gaussian* g, F radius) {
#if ACTOR_MOTION
  if (g->actor.any) return actor_travel(&g->actor, g->offset, radius);
#endif
  return (F)R(0.0);
}

#endif

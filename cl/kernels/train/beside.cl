// beside.cl - what a recorded picture shows of the surfaces that are seen from beside it. Launcher: host/render/train/beside.cpp
#include "math/elementary.h"
#include "math/shutter.h"
#include "shared/layout.h"

#define OPAQUE R(0.2)  // light that goes on behind a surface, at most: mixed distances are nobody's
#define SAME R(0.03)   // of the distance: what stands that near to a surface is part of it

/// m; negative where no surface stands alone in the way.
FN real surface_distance(__global const real* out, uint slots, uint slot) {
  const real passes = out[SIM_O_TRANSMITTANCE * slots + slot];
  if (!(passes < OPAQUE)) return R(-1.0);
  return out[SIM_O_DISTANCE * slots + slot] / (R(1.0) - passes);
}

/// V slots per work-item: where their rays meet surfaces, where the recorded picture shows that place, and, if what it
/// shows there is as far away as the place is, in which colour: between the four pixels around it, all of them known.
/// in  frame, now, world_ray[3|6|7][slots], met[5][slots]: the view beside, as it was rendered of the surfaces;
///     recorded, seen[5][slots]: the same of the view that was recorded; slot_of_ray[height][width], -1: no ray;
///     picture[3][slots]: recorded, negative: not known
/// out shown[3][slots]: -1 where the picture does not tell
__kernel void beside(const FrameParams frame,
                     const uint width,
                     const uint height,
                     __global const SensorConstants* now,
                     __global const real* world_ray,
                     __global const real* met,
                     __global const SensorConstants* recorded,
                     __global const real* seen,
                     __global const int* slot_of_ray,
                     __global const real* picture,
                     __global real* shown) {
  const uint i = get_global_id(0) * V;
  const uint s = frame.slots;
  if (i >= s) return;
  F d[3], p[3], q[3], x, y;
  for (int k = 0; k < 3; ++k) d[k] = LDV(world_ray + k * s + i);
  real distance[V], away[V], column[V], row[V], usable[V];
  for (uint lane = 0; lane < V; ++lane) distance[lane] = surface_distance(met, s, i + lane);
  const F far = LDV(distance);
  I valid = AND(is_ray(d[0], d[1], d[2]), far > R(0.0));
  for (int k = 0; k < 3; ++k) {
    p[k] = fma(far, d[k], (F)(now->centre_ref[k] - recorded->centre_ref[k]));
#if ORIGINS
    p[k] += LDV(world_ray + (3 + k) * s + i);
#endif
  }
  project_at_own_time(recorded, STANDS, p, (F)(R(0.5) * (real)width), (F)R(0.5), &x, &y, &valid);
  valid = AND(valid, AND(AND(x >= R(0.0), x < (F)(real)width), AND(y >= R(0.0), y < (F)(real)height)));
  STV(column, SEL(valid, x, (F)R(0.0)));
  STV(row, SEL(valid, y, (F)R(0.0)));
  sensor_from_world_point(recorded, p, time_of(recorded, x, y), q);
  STV(away, sqrt(fma(q[0], q[0], fma(q[1], q[1], q[2] * q[2]))));
  STV(usable, SEL(valid, (F)R(1.0), (F)R(0.0)));
  for (uint lane = 0; lane < V; ++lane) {
    real colour[3] = {R(-1.0), R(-1.0), R(-1.0)};
    if (usable[lane] > R(0.0)) {
      const int at = slot_of_ray[(uint)row[lane] * width + (uint)column[lane]];
      const real there = at < 0 ? R(-1.0) : surface_distance(seen, s, (uint)at);
      if (there > R(0.0) && fabs(there - away[lane]) <= SAME * away[lane]) {
        const real u = clamp(column[lane] - R(0.5), R(0.0), (real)(width - 1));
        const real v = clamp(row[lane] - R(0.5), R(0.0), (real)(height - 1));
        const uint x0 = (uint)u, y0 = (uint)v;
        const uint x1 = min(x0 + 1, width - 1), y1 = min(y0 + 1, height - 1);
        const int slots[4] = {slot_of_ray[y0 * width + x0],
                              slot_of_ray[y0 * width + x1],
                              slot_of_ray[y1 * width + x0],
                              slot_of_ray[y1 * width + x1]};
        bool known = true;
        for (int k = 0; k < 4; ++k) known = known && slots[k] >= 0 && picture[slots[k]] >= R(0.0);
        const real right = u - (real)x0, down = v - (real)y0;
        for (int c = 0; c < 3 && known; ++c) {
          __global const real* from = picture + (ulong)c * s;
          const real top = fma(right, from[slots[1]] - from[slots[0]], from[slots[0]]);
          const real bottom = fma(right, from[slots[3]] - from[slots[2]], from[slots[2]]);
          colour[c] = fma(down, bottom - top, top);
        }
      }
    }
    for (int c = 0; c < 3; ++c) shown[(ulong)c * s + i + lane] = colour[c];
  }
}

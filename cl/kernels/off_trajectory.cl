// off_trajectory.cl - colours of a recorded picture for surfaces seen in an off-trajectory view. Launcher: host/device/render/train/off_trajectory.cpp
#include "math/elementary.h"
#include "math/shutter.h"
#include "shared/layout.h"

#define SIM_OFF_TRAJECTORY_OPAQUE \
  R(0.2)  // largest transmittance behind a single surface; above it the distance is a mixture
#define SIM_OFF_TRAJECTORY_OPEN R(0.95)  // smallest transmittance of an empty ray
#define SIM_OFF_TRAJECTORY_SAME R(0.03)  // relative distance within which points belong to the same surface
// Rays without LiDAR surface: smallest distance in m of a hidden surface, number of distances (uniform in
// 1/distance) at which the picture is sampled, and the largest difference between their channels.
#define SIM_OFF_TRAJECTORY_NEAREST R(4.0)
#define SIM_OFF_TRAJECTORY_FARTHEST R(1e5)
#define SIM_OFF_TRAJECTORY_LOOKS 16
#define SIM_OFF_TRAJECTORY_ALIKE R(0.04)

/// Returns the distance in m of a single opaque surface; negative if there is none.
FN real surface_distance(__global const real* out, uint slots, uint slot) {
  const real passes = out[SIM_O_TRANSMITTANCE * slots + slot];
  if (!(passes < SIM_OFF_TRAJECTORY_OPAQUE)) return R(-1.0);
  return out[SIM_O_DISTANCE * slots + slot] / (R(1.0) - passes);
}

FN bool is_open(__global const real* out, uint slots, uint slot) {
  return out[SIM_O_TRANSMITTANCE * slots + slot] > SIM_OFF_TRAJECTORY_OPEN;
}

/// Bilinear colour at a picture position; false unless all four pixels are known.
FN bool colour_at(__global const real* picture,
                  __global const int* slot_of_ray,
                  uint slots,
                  uint width,
                  uint height,
                  real column,
                  real row,
                  real* colour) {
  const real u = clamp(column - R(0.5), R(0.0), (real)(width - 1));
  const real v = clamp(row - R(0.5), R(0.0), (real)(height - 1));
  const uint x0 = (uint)u, y0 = (uint)v;
  const uint x1 = min(x0 + 1, width - 1), y1 = min(y0 + 1, height - 1);
  const int around[4] = {slot_of_ray[y0 * width + x0],
                         slot_of_ray[y0 * width + x1],
                         slot_of_ray[y1 * width + x0],
                         slot_of_ray[y1 * width + x1]};
  bool known = true;  // no early exit: GPUs then keep their arrays in registers
  SIM_EACH(k, 4) known = known && around[k] >= 0 && picture[around[k]] >= R(0.0);
  if (!known) return false;
  const real right = u - (real)x0, down = v - (real)y0;
  SIM_EACH(c, 3) {
    __global const real* from = picture + (ulong)c * slots;
    const real top = fma(right, from[around[1]] - from[around[0]], from[around[0]]);
    const real bottom = fma(right, from[around[3]] - from[around[2]], from[around[2]]);
    colour[c] = fma(down, bottom - top, top);
  }
  return true;
}

/// Colours an off-trajectory view from a recorded picture. V slots per work-item. A ray that hits a surface
/// gets the bilinear colour where the recorded picture shows that point, if the picture's surface there is at
/// the point's distance and all four pixels are known. A ray that hits nothing (sky, and objects above the
/// LiDARs' field of view) gets the common colour of all points along the ray from SIM_OFF_TRAJECTORY_NEAREST
/// on, if there is one: any surface at any distance would have this colour. Points in front of the picture's
/// surface are empty; points behind it are unknown.
/// in  frame, now, world_ray[3|6|7][slots], met[5][slots]: the off-trajectory view, rendered from the LiDAR
///     surfaces; recorded, seen[5][slots]: the same for the recorded view; slot_of_ray[height][width], -1: no
///     ray; picture[3][slots]: recorded, negative: unknown
/// out shown[3][slots]: -1 where the colour is unknown
__kernel void off_trajectory(const FrameParams frame,
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
  F d[3];
  SIM_EACH(k, 3) d[k] = LDV(world_ray + k * s + i);
  const I is_one = is_ray(d[0], d[1], d[2]);
  real colour[V][3], distance[V];
  bool is_requested[V], is_free[V];
  SIM_EACH(lane, V) {
    distance[lane] = surface_distance(met, s, i + lane);
    is_free[lane] = is_open(met, s, i + lane);
    is_requested[lane] = is_free[lane] || distance[lane] > R(0.0);
    if (is_free[lane]) distance[lane] = SIM_OFF_TRAJECTORY_FARTHEST;
    SIM_EACH(c, 3) colour[lane][c] = R(-1.0);
  }
  Gaussian stands;
  stand_still(&stands);
  bool goes_on = true;
  for (int look = 0; look < SIM_OFF_TRAJECTORY_LOOKS && goes_on; ++look) {
    F p[3], q[3], x, y;
    real away[V], column[V], row[V], usable[V];
    const F far = LDV(distance);
    I valid = AND(is_one, far > R(0.0));
    SIM_EACH(k, 3) {
      p[k] = fma(far, d[k], (F)(now->centre_ref[k] - recorded->centre_ref[k]));
#if ORIGINS
      p[k] += LDV(world_ray + (3 + k) * s + i);
#endif
    }
    project_at_own_time(recorded, &stands, p, (F)(R(0.5) * (real)width), (F)R(0.5), &x, &y, &valid);
    valid = AND(valid, AND(AND(x >= R(0.0), x < (F)(real)width), AND(y >= R(0.0), y < (F)(real)height)));
    STV(column, SEL(valid, x, (F)R(0.0)));
    STV(row, SEL(valid, y, (F)R(0.0)));
    sensor_from_world_point(recorded, p, time_of(recorded, x, y), q);
    STV(away, sqrt(fma(q[0], q[0], fma(q[1], q[1], q[2] * q[2]))));
    STV(usable, SEL(valid, (F)R(1.0), (F)R(0.0)));
    goes_on = false;
    SIM_EACH(lane, V) {
      if (!is_requested[lane]) continue;
      const int at = usable[lane] > R(0.0) ? slot_of_ray[(uint)row[lane] * width + (uint)column[lane]] : -1;
      const real there = at < 0 ? R(-1.0) : surface_distance(seen, s, (uint)at);
      const bool is_past =
          is_free[lane] && look > 0 && there > (R(1.0) + SIM_OFF_TRAJECTORY_SAME) * away[lane];
      if (!is_past) {
        const bool is_it = is_free[lane] ? at >= 0 && is_open(seen, s, (uint)at)
                                         : there > R(0.0) && fabs(there - away[lane]) <=
                                                                 SIM_OFF_TRAJECTORY_SAME * away[lane];
        real found[3] = {R(0.0), R(0.0), R(0.0)};
        bool is_known =
            is_it && colour_at(picture, slot_of_ray, s, width, height, column[lane], row[lane], found);
        SIM_EACH(c, 3) {
          is_known = is_known && (look == 0 || fabs(found[c] - colour[lane][c]) <= SIM_OFF_TRAJECTORY_ALIKE);
        }
        SIM_EACH(c, 3) {
          const real first = look == 0 ? found[c] : colour[lane][c];
          colour[lane][c] = is_known ? first : R(-1.0);
        }
        is_requested[lane] = is_known && is_free[lane];
      }
      if (!is_requested[lane]) continue;
      goes_on = true;
      distance[lane] = SIM_OFF_TRAJECTORY_NEAREST * (real)(SIM_OFF_TRAJECTORY_LOOKS - 1) / (real)(look + 1);
    }
  }
  SIM_EACH(lane, V) {
    SIM_EACH(c, 3) shown[(ulong)c * s + i + lane] = colour[lane][c];
  }
}

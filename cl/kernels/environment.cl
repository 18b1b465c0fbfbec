// environment.cl - composites a frame over the environment map. Launcher: host/device/render/frame/environment.cpp
#include "math/environment.h"
#include "shared/layout.h"
#include "shared/sensor_constants.h"

/// Adds the environment seen through the remaining transmittance (METHOD section 9): out += T x
/// texture(direction), bilinear. Rays that terminated early (T below the cut) get none. V slots per work-item.
/// in  world_ray[3][slots]; texture[height][width][4]; out[6][slots] blended over black
/// out out[3][slots]: features
__kernel void environment(const FrameParams frame,
                          const uint width,
                          const uint height,
                          __global const SensorConstants* sensor,
                          __global const real* world_ray,
                          __global const real* texture,
                          __global real* out) {
  const uint i = get_global_id(0) * V;
  const uint s = frame.slots;
  if (i >= s) return;
  const F left = LDV(out + SIM_O_TRANSMITTANCE * s + i);
  const I open = left >= sensor->transmittance_cut;
  if (!ANY(open)) return;
  F x, y;
  environment_place(
      LDV(world_ray + i), LDV(world_ray + s + i), LDV(world_ray + 2 * s + i), width, height, &x, &y);
  real px[V], py[V], colour[3 * V];
  STV(px, x);
  STV(py, y);
  SIM_EACH(lane, V) {
    const EnvironmentTexels t = environment_texels(px[lane], py[lane], width, height);
    const __global real* above = texture + 4 * (ulong)(t.row * width);
    const __global real* below = above + 4 * width;
    const REAL_VECTOR(4) top =
        vload4(t.column, above) * (R(1.0) - t.fx) + vload4(t.next_column, above) * t.fx;
    const REAL_VECTOR(4) bottom =
        vload4(t.column, below) * (R(1.0) - t.fx) + vload4(t.next_column, below) * t.fx;
    const REAL_VECTOR(4) here = top * (R(1.0) - t.fy) + bottom * t.fy;
    colour[lane] = here.s0;
    colour[V + lane] = here.s1;
    colour[2 * V + lane] = here.s2;
  }
  const F share = SEL(open, left, (F)R(0.0));
  SIM_EACH(c, 3) STV(out + c * s + i, fma(share, LDV(colour + c * V), LDV(out + c * s + i)));
}

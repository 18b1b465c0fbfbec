// loss_ssim.cl - structural similarity of a picture and its gradient. Launcher: host/device/render/train/loss_ssim.cpp
#include "math/elementary.h"
#include "math/pixel_row.h"
#include "shared/layout.h"

// 1 - SSIM summed over known pixels, one channel at a time (Wang et al. 2004, K1 = 0.01, K2 = 0.03, values in
// [0, 1]). The 11 x 11 Gaussian window is separable, and its weights are normalised over the known pixels in
// it: borders and masked pixels need no special rule, and inside the picture the values equal those of
// optim/base/metrics.hpp.
// Planes store the picture row by row, with a margin of zeros for the windows; no kernel writes the margin. A
// work-item processes V columns of one tile, 16 rows.
#define SIM_SSIM_RADIUS 5
#define SIM_SSIM_TAPS (2 * SIM_SSIM_RADIUS + 1)
#define SIM_SSIM_MARGIN_X 16
#define SIM_SSIM_C1 R(1e-4)
#define SIM_SSIM_C2 R(9e-4)

typedef struct {
  uint slot;    // of the strip's first pixel; the next rows' slots are SIM_SLOT_OF_ROW further
  uint pixel;   // of the strip's first pixel, in a plane
  uint stride;  // of the rows of a plane
  uint size;    // pixels of a plane
} Strip;

/// Returns false for work-items beyond the last strip.
FN int find_strip(const FrameParams* frame, Strip* strip) {
  const uint per_tile = SIM_TILE_SIDE / V;
  const uint tile = get_global_id(0) / per_tile;
  const uint column = get_global_id(0) % per_tile * V;
  strip->stride = frame->tiles_x * SIM_TILE_SIDE + 2 * SIM_SSIM_MARGIN_X;
  strip->size = strip->stride * (frame->tiles_y * SIM_TILE_SIDE + 2 * SIM_SSIM_RADIUS);
  strip->slot = tile * SIM_TILE_RAYS + SIM_SLOT_OF_COLUMN(column);
  strip->pixel = (tile / frame->tiles_x * SIM_TILE_SIDE + SIM_SSIM_RADIUS) * strip->stride +
                 tile % frame->tiles_x * SIM_TILE_SIDE + column + SIM_SSIM_MARGIN_X;
  return tile < frame->tiles_x * frame->tiles_y;
}

/// Loads the weights once for all rows, so that they stay in registers.
FN void load_taps(__global const real* window, real* taps) {
  SIM_EACH(k, SIM_SSIM_TAPS) taps[k] = window[k];
}

/// Window sum of a plane around V pixels, over pixels `step` apart.
FN F window_sum(__global const real* centre, const real* taps, uint step) {
  __global const real* at = centre - SIM_SSIM_RADIUS * step;
  F sum = (F)R(0.0);
  SIM_EACH(k, SIM_SSIM_TAPS) sum = fma(LDV(at + k * step), (F)taps[k], sum);
  return sum;
}

/// Writes the input planes of one channel.
/// in  world_ray[3][slots], picture[3][slots], truth[3][slots] as in loss_image
/// out planes[3]: 1 where the pixel is known, else 0; picture and truth of `channel` times that
__kernel void ssim_planes(const FrameParams frame,
                          const uint channel,
                          __global const real* world_ray,
                          __global const real* picture,
                          __global const real* truth,
                          __global real* planes) {
  Strip strip;
  if (!find_strip(&frame, &strip)) return;
  const uint s = frame.slots;
  for (uint row = 0; row < SIM_TILE_SIDE; ++row) {
    const uint i = strip.slot + SIM_SLOT_OF_ROW(row, 0);
    __global real* pixel = planes + strip.pixel + row * strip.stride;
    const F x = load_pixel_row(world_ray + i), y = load_pixel_row(world_ray + s + i);
    const F z = load_pixel_row(world_ray + 2 * s + i);
    const I known = AND(is_ray(x, y, z), load_pixel_row(truth + i) >= R(0.0));
    STV(pixel, SEL(known, (F)R(1.0), (F)R(0.0)));
    STV(pixel + strip.size, SEL(known, load_pixel_row(picture + channel * s + i), (F)R(0.0)));
    STV(pixel + 2 * strip.size, SEL(known, load_pixel_row(truth + channel * s + i), (F)R(0.0)));
  }
}

/// Sums moments along rows.
/// in  planes[3]; window[11]
/// out moments[6]: window sums along rows of known, x, y, x^2, y^2, x y
__kernel void ssim_moments(const FrameParams frame,
                           __global const real* window,
                           __global const real* planes,
                           __global real* moments) {
  Strip strip;
  if (!find_strip(&frame, &strip)) return;
  real taps[SIM_SSIM_TAPS];
  load_taps(window, taps);
  for (uint row = 0; row < SIM_TILE_SIDE; ++row) {
    const uint pixel = strip.pixel + row * strip.stride;
    F sum[6];
    SIM_EACH(m, 6) sum[m] = (F)R(0.0);
    SIM_EACH(k, SIM_SSIM_TAPS) {
      __global const real* at = planes + pixel + k - SIM_SSIM_RADIUS;
      const F w = (F)taps[k];
      const F x = LDV(at + strip.size), y = LDV(at + 2 * strip.size);
      const F wx = w * x, wy = w * y;
      sum[0] = fma(LDV(at), w, sum[0]);
      sum[1] += wx;
      sum[2] += wy;
      sum[3] = fma(wx, x, sum[3]);
      sum[4] = fma(wy, y, sum[4]);
      sum[5] = fma(wx, y, sum[5]);
    }
    SIM_EACH(m, 6) STV(moments + m * strip.size + pixel, sum[m]);
  }
}

/// Sums moments along columns, and computes SSIM and its derivatives.
/// in  planes[3], moments[6]; scale: dL/d(1 - SSIM) of every pixel
/// out slopes[3]: dL/d(window sum) of x, x^2 and x y, 0 where the pixel is unknown; sums[3][strips]: 1 - SSIM
///     of this channel
__kernel void ssim_windows(const FrameParams frame,
                           const uint channel,
                           const real scale,
                           __global const real* window,
                           __global const real* planes,
                           __global const real* moments,
                           __global real* slopes,
                           __global real* sums) {
  Strip strip;
  if (!find_strip(&frame, &strip)) return;
  real taps[SIM_SSIM_TAPS];
  load_taps(window, taps);
  F total = (F)R(0.0);
  for (uint row = 0; row < SIM_TILE_SIDE; ++row) {
    const uint pixel = strip.pixel + row * strip.stride;
    const I known = LDV(planes + pixel) > R(0.5);
    F m[6];
    SIM_EACH(k, 6) m[k] = window_sum(moments + k * strip.size + pixel, taps, strip.stride);
    const F inv_weight = R(1.0) / SEL(known, m[0], (F)R(1.0));
#pragma unroll
    for (int k = 1; k < 6; ++k) m[k] *= inv_weight;
    const F mean_product = m[1] * m[2];
    const F mean_squares = fma(m[1], m[1], m[2] * m[2]);
    const F a1 = fma(mean_product, (F)R(2.0), (F)SIM_SSIM_C1);
    const F a2 = fma(m[5] - mean_product, (F)R(2.0), (F)SIM_SSIM_C2);
    const F inv_b1 = R(1.0) / (mean_squares + SIM_SSIM_C1);
    const F inv_b2 = R(1.0) / (m[3] + m[4] - mean_squares + SIM_SSIM_C2);
    const F inv_b = inv_b1 * inv_b2;
    const F ssim = a1 * a2 * inv_b;
    total += SEL(known, R(1.0) - ssim, (F)R(0.0));
    const F by = SEL(known, -scale * inv_weight, (F)R(0.0));
    const F by_mean = R(2.0) * (m[2] * (a2 - a1) * inv_b - m[1] * ssim * (inv_b1 - inv_b2));
    STV(slopes + pixel, by * by_mean);
    STV(slopes + strip.size + pixel, -by * ssim * inv_b2);
    STV(slopes + 2 * strip.size + pixel, by * R(2.0) * a1 * inv_b);
  }
  const uint strips = frame.slots / (SIM_TILE_SIDE * V);
  sums[channel * strips + get_global_id(0)] = HSUM(total);
}

/// Window sums of slopes[3] along rows -> slope_rows[3].
__kernel void ssim_slope_rows(const FrameParams frame,
                              __global const real* window,
                              __global const real* slopes,
                              __global real* slope_rows) {
  Strip strip;
  if (!find_strip(&frame, &strip)) return;
  real taps[SIM_SSIM_TAPS];
  load_taps(window, taps);
  for (uint row = 0; row < SIM_TILE_SIDE; ++row) {
    const uint pixel = strip.pixel + row * strip.stride;
    SIM_EACH(k, 3) {
      const uint at = k * strip.size + pixel;
      STV(slope_rows + at, window_sum(slopes + at, taps, 1));
    }
  }
}

/// Adds this term's gradient to `channel`.
/// in  planes[3], slope_rows[3]
/// out grad_picture[3][slots]
__kernel void ssim_gradient(const FrameParams frame,
                            const uint channel,
                            __global const real* window,
                            __global const real* planes,
                            __global const real* slope_rows,
                            __global real* grad_picture) {
  Strip strip;
  if (!find_strip(&frame, &strip)) return;
  real taps[SIM_SSIM_TAPS];
  load_taps(window, taps);
  for (uint row = 0; row < SIM_TILE_SIDE; ++row) {
    const uint pixel = strip.pixel + row * strip.stride;
    F g[3];
    SIM_EACH(k, 3) g[k] = window_sum(slope_rows + k * strip.size + pixel, taps, strip.stride);
    const F x = LDV(planes + strip.size + pixel), y = LDV(planes + 2 * strip.size + pixel);
    const F gradient = fma(x, R(2.0) * g[1], fma(y, g[2], g[0]));
    __global real* slot = grad_picture + channel * frame.slots + strip.slot + SIM_SLOT_OF_ROW(row, 0);
    store_pixel_row(slot, fma(LDV(planes + pixel), gradient, load_pixel_row(slot)));
  }
}

// picture_bytes.cl - converts a picture to bytes. Launcher: host/device/render/outputs/picture_bytes.cpp
#include "math/pixel_row.h"

#if V == 1
#define SIM_TO_FLOATS(v) ((float)(v))
#define SIM_BYTES_FROM(v) ((uchar)(v))
typedef float Floats;
typedef int Ints;
typedef uchar Bytes;
#else
#define SIM_TO_FLOATS(v) LANES_CAT(convert_float, V)(v)
#define SIM_BYTES_FROM(v) LANES_CAT(convert_uchar, V)(v)
typedef LANES_CAT(float, V) Floats;
typedef LANES_CAT(int, V) Ints;
typedef LANES_CAT(uchar, V) Bytes;
#endif

/// Rounds half up and maps NaN to 0: the same bits as to_bytes() in io/picture.
FN Bytes bytes_of(F shown) {
  const Floats value = SIM_TO_FLOATS(shown);
  const Floats above = value > 0.0f ? value : (Floats)0.0f;
  const Floats steps = (above < 1.0f ? above : (Floats)1.0f) * 255.0f;
  const Ints whole = TO_INTS(steps);
  return SIM_BYTES_FROM(whole + (steps - SIM_TO_FLOATS(whole) >= 0.5f ? (Ints)1 : (Ints)0));
}

/// Converts V pixels of a row per work-item.
/// in  shown[3][slots]; slot_of_ray[height][width], -1: a pixel without a ray, which shows the background
/// out bytes[3 * width * height]: channel c of pixel i at i * pixel_step + c * channel_step
__kernel void picture_bytes(const uint width,
                            const uint height,
                            const uint slots,
                            __global const int* slot_of_ray,
                            __global const real* shown,
                            const real red,
                            const real green,
                            const real blue,
                            const uint pixel_step,
                            const uint channel_step,
                            __global uchar* bytes) {
  const uint of_row = (width + V - 1) / V;
  const uint y = get_global_id(0) / of_row;
  const uint x = get_global_id(0) % of_row * V;
  if (y >= height) return;
  const uint first = y * width + x;
  const uint count = min((uint)V, width - x);
  const real background[3] = {red, green, blue};
  bool is_run = count == V && slot_of_ray[first] >= 0;
  for (uint k = 1; k < count; ++k)
    is_run &= slot_of_ray[first + k] == slot_of_ray[first] + (int)SIM_SLOT_OF_COLUMN(k);
  if (is_run && pixel_step == 1) {
    __global const real* from = shown + slot_of_ray[first];
    SIM_EACH(c, 3) {
      const Bytes converted = bytes_of(load_pixel_row(from + c * slots));
      STV(bytes + first + c * channel_step, converted);
    }
    return;
  }
  SIM_EACH(c, 3) {
    real values[V];
#pragma unroll
    for (uint k = 0; k < V; ++k) {
      const int slot = k < count ? slot_of_ray[first + k] : -1;
      values[k] = slot < 0 ? background[c] : shown[c * slots + (uint)slot];
    }
    const Bytes converted = bytes_of(LDV(values));
    uchar each[V];
    STV(each, converted);
    __global uchar* to = bytes + first * pixel_step + c * channel_step;
    for (uint k = 0; k < count; ++k) to[k * pixel_step] = each[k];
  }
}

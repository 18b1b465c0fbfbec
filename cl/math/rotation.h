// rotation.h - 3x3 rotations and cross products on lanes, and a particle's rotation.
#ifndef SIMULI_CL_MATH_ROTATION_H
#define SIMULI_CL_MATH_ROTATION_H
#include "math/lanes.h"
#include "shared/layout.h"

/// out = R v, or R^T v, R row-major 3x3 on lanes.
FN void rotate_lanes(const F* r, const F* v, F* out) {
  SIM_EACH(k, 3) out[k] = r[3 * k] * v[0] + r[3 * k + 1] * v[1] + r[3 * k + 2] * v[2];
}
FN void rotate_back_lanes(const F* r, const F* v, F* out) {
  SIM_EACH(k, 3) out[k] = r[k] * v[0] + r[3 + k] * v[1] + r[6 + k] * v[2];
}

/// out = A B, 3x3 row-major on lanes.
FN void multiply_lanes(const F* a, const F* b, F* out) {
  SIM_EACH(i, 3) {
    SIM_EACH(j, 3) {
      out[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
    }
  }
}

FN void cross_lanes(const F* a, const F* b, F* out) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

/// Loads the unit quaternion (w, x, y, z) and the row-major rotation of the particles whose parameters start at
/// `column`; returns 1 / |raw quaternion|.
FN F load_rotation(const __global real* column, uint stride, F* quaternion, F* r) {
  F raw[4];
  SIM_EACH(k, 4) raw[k] = LDV(column + (SIM_ROTATION + k) * stride);
  const F inv_norm = R(1.0) / sqrt(raw[0] * raw[0] + raw[1] * raw[1] + raw[2] * raw[2] + raw[3] * raw[3]);
  SIM_EACH(k, 4) quaternion[k] = raw[k] * inv_norm;
  const F w = quaternion[0], x = quaternion[1], y = quaternion[2], z = quaternion[3];
  r[0] = R(1.0) - R(2.0) * (y * y + z * z);
  r[1] = R(2.0) * (x * y - w * z);
  r[2] = R(2.0) * (x * z + w * y);
  r[3] = R(2.0) * (x * y + w * z);
  r[4] = R(1.0) - R(2.0) * (x * x + z * z);
  r[5] = R(2.0) * (y * z - w * x);
  r[6] = R(2.0) * (x * z - w * y);
  r[7] = R(2.0) * (y * z + w * x);
  r[8] = R(1.0) - R(2.0) * (x * x + y * y);
  return inv_norm;
}

#endif

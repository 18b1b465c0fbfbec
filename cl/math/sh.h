// sh.h - real spherical harmonics up to degree 3, with basis and signs of the 3DGS file format: one text for
// the device and the host (host/core/scene/placement.cpp). Coefficient k of channel c is in parameter row
// SIM_SH + 3 k + c.
#ifndef SIMULI_CL_MATH_SH_H
#define SIMULI_CL_MATH_SH_H
#ifndef __cplusplus
#include "math/lanes.h"
#include "shared/layout.h"
#endif

#define SH_COEFFICIENTS ((SH_DEGREE + 1) * (SH_DEGREE + 1))

// Build: SH_HALF = 1 when rows from SIM_SH on are halves (float only).
#ifndef SH_HALF
#define SH_HALF 0
#endif

/// Coefficients k of `channel` of V particles from number i on, or of that one alone, from
/// params[rows][stride].
#if SH_HALF
#define SH_ROW(params, stride, k, channel) \
  ((const __global half*)((params) + (ulong)SIM_SH * (stride)) + (ulong)(3 * (k) + (channel)) * (stride))
#define SH_ONE(params, stride, k, channel, i) vload_half((i), SH_ROW(params, stride, k, channel))
#if V == 1
#define SH_LANES SH_ONE
#else
#define SH_LANES(params, stride, k, channel, i) \
  LANES_CAT(vload_half, V)(0, SH_ROW(params, stride, k, channel) + (i))
#endif
#else
#define SH_ROW(params, stride, k, channel) ((params) + (ulong)(SIM_SH + 3 * (k) + (channel)) * (stride))
#define SH_ONE(params, stride, k, channel, i) SH_ROW(params, stride, k, channel)[i]
#define SH_LANES(params, stride, k, channel, i) LDV(SH_ROW(params, stride, k, channel) + (i))
#endif

#ifndef __cplusplus
/// Prefetches the first `rows` parameters, or the coefficients, of particles i .. i+V-1: hardware does not
/// predict that many parallel streams.
FN void call_for_rows(__global const real* params, uint stride, uint rows, uint i) {
  for (uint row = 0; row < rows; ++row) SIM_PREFETCH(params + (ulong)row * stride + i);
}
FN void call_for_sh(__global const real* params, uint stride, uint i) {
  SIM_EACH(k, SH_COEFFICIENTS) {
    SIM_EACH(channel, 3) SIM_PREFETCH(SH_ROW(params, stride, k, channel) + i);
  }
}
#endif

/// Basis values at the unit direction (x, y, z).
FN void sh_basis(F x, F y, F z, F* basis) {
  basis[0] = (F)R(0.28209479177387814);
#if SH_DEGREE > 0
  basis[1] = y * R(-0.4886025119029199);
  basis[2] = z * R(0.4886025119029199);
  basis[3] = x * R(-0.4886025119029199);
#endif
#if SH_DEGREE > 1
  const F xx = x * x, yy = y * y, zz = z * z;
  basis[4] = x * y * R(1.0925484305920792);
  basis[5] = y * z * R(-1.0925484305920792);
  basis[6] = (R(2.0) * zz - xx - yy) * R(0.31539156525252005);
  basis[7] = x * z * R(-1.0925484305920792);
  basis[8] = (xx - yy) * R(0.5462742152960396);
#endif
#if SH_DEGREE > 2
  basis[9] = y * (R(3.0) * xx - yy) * R(-0.5900435899266435);
  basis[10] = x * y * z * R(2.890611442640554);
  basis[11] = y * (R(4.0) * zz - xx - yy) * R(-0.4570457994644658);
  basis[12] = z * (R(2.0) * zz - R(3.0) * xx - R(3.0) * yy) * R(0.3731763325901154);
  basis[13] = x * (R(4.0) * zz - xx - yy) * R(-0.4570457994644658);
  basis[14] = z * (xx - yy) * R(1.445305721320277);
  basis[15] = x * (xx - R(3.0) * yy) * R(-0.5900435899266435);
#endif
}

#if SH_DEGREE > 0
/// Gradient in (x, y, z) of sum_k weight[k] basis[k], with the polynomials extended off the unit sphere.
FN void sh_gradient(F x, F y, F z, const F* weight, F* gradient) {
  F gx = weight[3] * R(-0.4886025119029199);
  F gy = weight[1] * R(-0.4886025119029199);
  F gz = weight[2] * R(0.4886025119029199);
#if SH_DEGREE > 1
  const F w4 = weight[4] * R(1.0925484305920792);
  const F w5 = weight[5] * R(-1.0925484305920792);
  const F w6 = weight[6] * R(0.31539156525252005);
  const F w7 = weight[7] * R(-1.0925484305920792);
  const F w8 = weight[8] * R(0.5462742152960396);
  gx += w4 * y - R(2.0) * w6 * x + w7 * z + R(2.0) * w8 * x;
  gy += w4 * x + w5 * z - R(2.0) * w6 * y - R(2.0) * w8 * y;
  gz += w5 * y + R(4.0) * w6 * z + w7 * x;
#endif
#if SH_DEGREE > 2
  const F xx = x * x, yy = y * y, zz = z * z;
  const F w9 = weight[9] * R(-0.5900435899266435);
  const F w10 = weight[10] * R(2.890611442640554);
  const F w11 = weight[11] * R(-0.4570457994644658);
  const F w12 = weight[12] * R(0.3731763325901154);
  const F w13 = weight[13] * R(-0.4570457994644658);
  const F w14 = weight[14] * R(1.445305721320277);
  const F w15 = weight[15] * R(-0.5900435899266435);
  gx += R(6.0) * w9 * x * y + w10 * y * z - R(2.0) * w11 * x * y - R(6.0) * w12 * x * z +
        w13 * (R(4.0) * zz - R(3.0) * xx - yy) + R(2.0) * w14 * x * z + R(3.0) * w15 * (xx - yy);
  gy += w9 * R(3.0) * (xx - yy) + w10 * x * z + w11 * (R(4.0) * zz - xx - R(3.0) * yy) -
        R(6.0) * w12 * y * z - R(2.0) * w13 * x * y - R(2.0) * w14 * y * z - R(6.0) * w15 * x * y;
  gz += w10 * x * y + R(8.0) * w11 * y * z + w12 * (R(6.0) * zz - R(3.0) * xx - R(3.0) * yy) +
        R(8.0) * w13 * x * z + w14 * (xx - yy);
#endif
  gradient[0] = gx;
  gradient[1] = gy;
  gradient[2] = gz;
}
#endif

#endif

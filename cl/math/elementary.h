// elementary.h - exp, atan2 and related functions on lanes. Float: polynomials, because the built-in functions
// are scalar calls on CPU drivers (3-13 ns each); double: the built-in functions.
#ifndef SIMULI_CL_MATH_ELEMENTARY_H
#define SIMULI_CL_MATH_ELEMENTARY_H
#include "math/lanes.h"

#define PI_R R(3.14159265358979323846)
#define TWO_PI_R R(6.28318530717958647693)
#define HALF_PI_R R(1.57079632679489661923)

#ifdef SIMULI_REAL_DOUBLE
FN F exp_lanes(F x) { return exp(x); }
FN F round_lanes(F x) { return rint(x); }
FN F atan2_lanes(F y, F x) { return atan2(y, x); }
FN void sincos_lanes(F x, F* sine, F* cosine) { *sine = sincos(x, cosine); }
#else
#if V == 1
#define AS_F(x) as_float(x)
#define AS_I(x) as_int(x)
#else
#define AS_F(x) LANES_CAT(as_float, V)(x)
#define AS_I(x) LANES_CAT(as_int, V)(x)
#endif

/// Adding 1.5 * 2^23 leaves the nearest integer in the low bits (needs strict float arithmetic).
#define ROUND_MAGIC 12582912.0f

/// Nearest integer of |x| < 2^22.
FN F round_lanes(F x) { return (x + ROUND_MAGIC) - ROUND_MAGIC; }

/// exp(x) for -87 < x < 88, relative error below 2.5e-7; minimax polynomial of 2^f on [-1/2, 1/2].
FN F exp_lanes(F x) {
  const F scaled = x * 1.44269504f;
  const F magic = scaled + ROUND_MAGIC;
  // x - n ln 2 in two steps: rounding x * log2(e) alone would cost |x| * 6e-8.
  const F n = magic - ROUND_MAGIC;
  const F f = fma(x, (F)1.44269504f, -n) + x * 1.92596299e-8f;
  F p = fma((F)0.0013276472f, f, (F)0.00967554174f);
  p = fma(p, f, (F)0.0555071328f);
  p = fma(p, f, (F)0.240221197f);
  p = fma(p, f, (F)0.693146967f);
  p = fma(p, f, (F)1.00000007f);
  return AS_F(AS_I(p) + (AS_I(magic) << 23));
}

/// Sine and cosine of |x| < 1000 rad within 2e-7; minimax polynomials on [-pi/4, pi/4].
FN void sincos_lanes(F x, F* sine, F* cosine) {
  const F quarter = round_lanes(x * 0.636619772f);
  // pi / 2 in two parts: the first alone has an error of 4e-8.
  F r = fma(quarter, (F)-1.57079637f, x);
  r = fma(quarter, (F)4.37113883e-8f, r);
  const F r2 = r * r;
  F s = fma((F)-0.000195108387f, r2, (F)0.00833213149f);
  s = fma(s, r2, (F)-0.166666542f);
  s = fma(s * r2, r, r);
  F c = fma((F)2.44312046e-5f, r2, (F)-0.0013887306f);
  c = fma(c, r2, (F)0.0416666457f);
  c = fma(c * r2, r2, fma(r2, (F)-0.5f, (F)1.0f));
  // Odd quarters swap sine and cosine; the second half of the period changes their signs.
  const F half_turns = round_lanes(quarter * 0.5f - 0.25f);
  const F odd = quarter - 2.0f * half_turns;
  const F sign = 1.0f - 2.0f * fabs(half_turns - 2.0f * round_lanes(half_turns * 0.5f));
  const F first = SEL(odd > 0.5f, c, s);
  const F second = SEL(odd > 0.5f, -s, c);
  *sine = first * sign;
  *cosine = second * sign;
}

/// atan2(y, x) within 3e-7 rad (near pi floats are 2.4e-7 apart), 3.8e-7 where divisions have the 2.5 ulp error
/// that OpenCL allows; atan2(0, 0) = 0. Minimax polynomial of atan on [0, 1].
FN F atan2_lanes(F y, F x) {
  const F ax = fabs(x);
  const F ay = fabs(y);
  const F big = VMAX(ax, ay);
  const F small = VMIN(ax, ay);
  const F t = SEL(big > 0.0f, small / big, (F)0.0f);
  const F t2 = t * t;
  F p = fma((F)-0.00405455905f, t2, (F)0.02186293f);
  p = fma(p, t2, (F)-0.0559122893f);
  p = fma(p, t2, (F)0.0964219482f);
  p = fma(p, t2, (F)-0.139086287f);
  p = fma(p, t2, (F)0.199465655f);
  p = fma(p, t2, (F)-0.333298608f);
  p = fma(p, t2, (F)0.999999336f) * t;
  p = SEL(ay > ax, HALF_PI_R - p, p);
  p = SEL(x < 0.0f, PI_R - p, p);
  return SEL(y < 0.0f, -p, p);
}
#endif

/// Lanes with an active ray: slots without a ray and terminated rays have a zero direction.
FN I is_ray(F x, F y, F z) { return OR(OR(x != R(0.0), y != R(0.0)), z != R(0.0)); }

/// x wrapped to [-period/2, period/2].
FN F wrap_lanes(F x, real period) { return fma(round_lanes(x * (R(1.0) / period)), (F)-period, x); }

#endif

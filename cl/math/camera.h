// camera.h - projection of points by every camera model: one text for the device (float or double, any number
// of lanes) and for the host (double; host/core/sensors/lens/lens_forward.hpp defines F, I, SEL, ... there).
// A point (x, y, z) in m in the camera frame (x right, y down, z forward) has the image (u, v) in focal lengths
// from the principal point. `valid` is cleared where it has none: outside the domain in which the map is
// injective (LensConstants, found on the host), or nearer than 1 cm. No image is clamped into the picture.
#ifndef SIMULI_CL_MATH_CAMERA_H
#define SIMULI_CL_MATH_CAMERA_H
#ifndef __cplusplus
#include "math/elementary.h"
#include "shared/sensor_constants.h"
#define REALS __global const real*
#define LENS_CONSTANTS __global const LensConstants*
#endif

#define CAMERA_NEAR R(0.01)       // m
#define PINHOLE_COS2_MIN R(0.01)  // z >= 0.1 of the distance: about 84 degrees off axis
#define FTHETA_MAX_ITERATIONS 32
#define BEND_STEPS 4  // iterations from an error of one degree to double precision

/// Distorted coordinates, their Jacobian, and whether the map preserves orientation there.
typedef struct {
  F u, v;
  F u_x, u_y, v_x, v_y;
  I regular;
} Distorted;

/// OpenCV's rational radial, tangential and thin-prism distortion at (x, y) = (X, Y) / Z. k: k1 k2 p1 p2 k3 k4
/// k5 k6 s1 s2 s3 s4
FN void distort(REALS k, F x, F y, Distorted* out) {
  const real k1 = k[0], k2 = k[1], p1 = k[2], p2 = k[3], k3 = k[4], k4 = k[5], k5 = k[6], k6 = k[7];
  const real s1 = k[8], s2 = k[9], s3 = k[10], s4 = k[11];
  const F r2 = fma(x, x, y * y);
  const F above = fma(r2, fma(r2, fma(r2, (F)k3, (F)k2), (F)k1), (F)R(1.0));
  const F below = fma(r2, fma(r2, fma(r2, (F)k6, (F)k5), (F)k4), (F)R(1.0));
  const I finite = below > R(0.0);
  const F inv = R(1.0) / SEL(finite, below, (F)R(1.0));
  const F scale = above * inv;
  out->u = fma(x, scale, R(2.0) * p1 * x * y + p2 * fma((F)R(2.0), x * x, r2) + r2 * fma(r2, (F)s2, (F)s1));
  out->v = fma(y, scale, R(2.0) * p2 * x * y + p1 * fma((F)R(2.0), y * y, r2) + r2 * fma(r2, (F)s4, (F)s3));
  // Twice d scale / d r^2, and twice the thin prism's part of the derivative by r^2.
  const F above_1 = fma(r2, fma(r2, (F)(R(3.0) * k3), (F)(R(2.0) * k2)), (F)k1);
  const F below_1 = fma(r2, fma(r2, (F)(R(3.0) * k6), (F)(R(2.0) * k5)), (F)k4);
  const F slope = R(2.0) * (above_1 - scale * below_1) * inv;
  const F prism_u = fma(r2, (F)(R(4.0) * s2), (F)(R(2.0) * s1));
  const F prism_v = fma(r2, (F)(R(4.0) * s4), (F)(R(2.0) * s3));
  const F cross = slope * x * y + R(2.0) * p1 * x + R(2.0) * p2 * y;
  out->u_x = scale + slope * x * x + R(2.0) * p1 * y + R(6.0) * p2 * x + prism_u * x;
  out->u_y = cross + prism_u * y;
  out->v_x = cross + prism_v * x;
  out->v_y = scale + slope * y * y + R(6.0) * p1 * y + R(2.0) * p2 * x + prism_v * y;
  out->regular = AND(finite, out->u_x * out->v_y > out->u_y * out->v_x);
}

/// Evaluates a polynomial of two angles (SIM_BEND_TERMS coefficients) and its partial derivatives.
FN void bend_polynomial(REALS c, F a, F b, F* value, F* by_a, F* by_b) {
  F sum = (F)R(0.0), slope_a = sum, slope_b = sum;
  for (int j = 5; j >= 0; --j) {
    REALS row = c + j * (13 - j) / 2;
    F of_row = (F)row[5 - j], slope = (F)R(0.0);
    for (int i = 4 - j; i >= 0; --i) {
      slope = fma(slope, a, of_row);
      of_row = fma(of_row, a, (F)row[i]);
    }
    slope_b = fma(slope_b, b, sum);
    slope_a = fma(slope_a, b, slope);
    sum = fma(sum, b, of_row);
  }
  *value = sum;
  *by_a = slope_a;
  *by_b = slope_b;
}

/// One Newton step from (*at_a, *at_b) towards the solution of h = a, v = b; returns whether the map preserves
/// orientation there.
FN I bend_step(REALS h, REALS v, F a, F b, F* at_a, F* at_b) {
  F miss_a, h_a, h_b, miss_b, v_a, v_b;
  bend_polynomial(h, *at_a, *at_b, &miss_a, &h_a, &h_b);
  bend_polynomial(v, *at_a, *at_b, &miss_b, &v_a, &v_b);
  miss_a -= a;
  miss_b -= b;
  const F determinant = h_a * v_b - h_b * v_a;
  const I regular = determinant > R(0.0);
  const F inv = R(1.0) / SEL(regular, determinant, (F)R(1.0));
  *at_a -= (v_b * miss_a - h_b * miss_b) * inv;
  *at_b -= (h_a * miss_b - v_a * miss_a) * inv;
  return regular;
}

/// Moves a point in front of a windshield to the direction from which its ray arrives behind the windshield, at
/// the same distance: a = asin(x / r) and b = asin(y / r) are replaced by polynomials of both (NCore's
/// bivariate windshield). Polynomials given for the opposite direction are inverted by Newton steps from an
/// approximate inverse.
FN void bend_point(LENS_CONSTANTS lens, int is_backward, F* x, F* y, F* z, I* valid) {
  const F r = sqrt(*x * *x + *y * *y + *z * *z);
  const I ok = AND(r > CAMERA_NEAR, *z > lens->bend_cos_min * r);
  const F a = atan2_lanes(*x, sqrt(fma(*y, *y, SEL(ok, *z * *z, (F)R(1.0)))));
  const F b = atan2_lanes(*y, sqrt(fma(*x, *x, SEL(ok, *z * *z, (F)R(1.0)))));
  F bent_a, bent_b, unused_a, unused_b;
  if (is_backward) {
    bend_polynomial(lens->bend_back_horizontal, a, b, &bent_a, &unused_a, &unused_b);
    bend_polynomial(lens->bend_back_vertical, a, b, &bent_b, &unused_a, &unused_b);
    for (int k = 0; k < BEND_STEPS; ++k)
      (void)bend_step(lens->bend_horizontal, lens->bend_vertical, a, b, &bent_a, &bent_b);
  } else {
    bend_polynomial(lens->bend_horizontal, a, b, &bent_a, &unused_a, &unused_b);
    bend_polynomial(lens->bend_vertical, a, b, &bent_b, &unused_a, &unused_b);
  }
  F sine_a, sine_b, cosine;
  sincos_lanes(bent_a, &sine_a, &cosine);
  sincos_lanes(bent_b, &sine_b, &cosine);
  const F left = R(1.0) - sine_a * sine_a - sine_b * sine_b;
  const I shown = AND(ok, left > R(0.0));
  *x = r * sine_a;
  *y = r * sine_b;
  *z = r * sqrt(SEL(shown, left, (F)R(1.0)));
  *valid = AND(*valid, shown);
}

FN void pinhole_image(F x, F y, F z, F* u, F* v, I* valid) {
  const F r2 = x * x + y * y + z * z;
  const I ok = AND(z > CAMERA_NEAR, z * z >= PINHOLE_COS2_MIN * r2);
  const F inv_z = R(1.0) / SEL(ok, z, (F)R(1.0));
  *u = x * inv_z;
  *v = y * inv_z;
  *valid = AND(*valid, ok);
}

FN void opencv_pinhole_image(LENS_CONSTANTS lens, F x, F y, F z, F* u, F* v, I* valid) {
  F a, b;
  pinhole_image(x, y, z, &a, &b, valid);
  Distorted d;
  distort(lens->distortion, a, b, &d);
  *u = d.u;
  *v = d.v;
  // The determinant becomes negative at the fold, whose radius depends on the direction; beyond the largest
  // fold radius it may become positive again.
  *valid = AND(*valid, AND(d.regular, fma(a, a, b * b) <= lens->radius2_max));
}

/// Image at the radius rho(angle) in the direction of (x, y); on the axis rho / r is 1 / z.
FN void radial_image(F rho, F r, F x, F y, F z, F* u, F* v) {
  const I off_axis = r > R(0.0);
  const F scale = SEL(off_axis, rho, (F)R(1.0)) / SEL(off_axis, r, VMAX(z, (F)CAMERA_NEAR));
  *u = x * scale;
  *v = y * scale;
}

FN I far_enough(F r, F z) { return fma(r, r, z * z) > CAMERA_NEAR * CAMERA_NEAR; }

FN void opencv_fisheye_image(LENS_CONSTANTS lens, F x, F y, F z, F* u, F* v, I* valid) {
  const F r = sqrt(fma(x, x, y * y));
  const F angle = atan2_lanes(r, z);
  const F a2 = angle * angle;
  REALS k = lens->polynomial;
  const F rho = angle * fma(a2, fma(a2, fma(a2, fma(a2, (F)k[3], (F)k[2]), (F)k[1]), (F)k[0]), (F)R(1.0));
  radial_image(rho, r, x, y, z, u, v);
  *valid = AND(*valid, AND(angle <= lens->angle_max, far_enough(r, z)));
}

/// a[0] t + a[1] t^2 + ... + a[4] t^5
FN F polynomial5(REALS a, F t) {
  return t * fma(t, fma(t, fma(t, fma(t, (F)a[4], (F)a[3]), (F)a[2]), (F)a[1]), (F)a[0]);
}
FN F polynomial5_slope(REALS a, F t) {
  return fma(
      t,
      fma(t, fma(t, fma(t, (F)(R(5.0) * a[4]), (F)(R(4.0) * a[3])), (F)(R(3.0) * a[2])), (F)(R(2.0) * a[1])),
      (F)a[0]);
}

/// Solves polynomial5(a, t) = value for t in [0, t_max], for an increasing polynomial: Newton steps, bisection
/// when they leave the bracket. Ends when no lane changes.
FN F polynomial5_inverse(REALS a, F value, real t_max) {
  F low = (F)R(0.0), high = (F)t_max;
  F t = VMIN(value * (R(1.0) / a[0]), high);
  for (int k = 0; k < FTHETA_MAX_ITERATIONS; ++k) {
    const F error = polynomial5(a, t) - value;
    low = SEL(error <= R(0.0), t, low);
    high = SEL(error >= R(0.0), t, high);
    const F newton = t - error / polynomial5_slope(a, t);
    const I inside = AND(newton >= low, newton <= high);
    const F next = SEL(inside, newton, R(0.5) * (low + high));
    const I moved = next != t;
    t = next;
    if (!ANY(moved)) break;
  }
  return t;
}

FN void ftheta_linear(LENS_CONSTANTS lens, F x, F y, F* u, F* v) {
  *u = fma((F)lens->linear[0], x, lens->linear[1] * y);
  *v = fma((F)lens->linear[2], x, y);
}

FN void ftheta_image(LENS_CONSTANTS lens, F x, F y, F z, F* u, F* v, I* valid) {
  const F r = sqrt(fma(x, x, y * y));
  const F angle = atan2_lanes(r, z);
  F a, b;
  radial_image(polynomial5(lens->polynomial, angle), r, x, y, z, &a, &b);
  ftheta_linear(lens, a, b, u, v);
  *valid = AND(*valid, AND(angle <= lens->angle_max, far_enough(r, z)));
}

FN void ftheta_inverse_image(LENS_CONSTANTS lens, F x, F y, F z, F* u, F* v, I* valid) {
  const F r = sqrt(fma(x, x, y * y));
  const F angle = atan2_lanes(r, z);
  const I ok = AND(angle <= lens->angle_max, far_enough(r, z));
  const F rho = polynomial5_inverse(lens->polynomial, SEL(ok, angle, (F)R(0.0)), lens->radius_max);
  F a, b;
  radial_image(rho, r, x, y, z, &a, &b);
  ftheta_linear(lens, a, b, u, v);
  *valid = AND(*valid, ok);
}

/// The unified (Mei) model: projects to the unit sphere, then to the plane z = 1 from (0, 0, -xi), then
/// distorts.
FN void mei_image(LENS_CONSTANTS lens, F x, F y, F z, F* u, F* v, I* valid) {
  const F r = sqrt(x * x + y * y + z * z);
  const I ok = AND(r > CAMERA_NEAR, z > lens->cos_min * r);
  const F inv = R(1.0) / SEL(ok, fma(r, (F)lens->xi, z), (F)R(1.0));
  const F a = x * inv, b = y * inv;
  Distorted d;
  distort(lens->distortion, a, b, &d);
  *u = d.u;
  *v = d.v;
  *valid = AND(*valid, AND(ok, AND(d.regular, fma(a, a, b * b) <= lens->radius2_max)));
}

/// (azimuth, elevation) in rad: the picture's x runs once around the y axis, to the right of z.
FN void equirectangular_image(F x, F y, F z, F* u, F* v, I* valid) {
  const F flat = sqrt(fma(x, x, z * z));
  *u = atan2_lanes(x, z);
  *v = atan2_lanes(y, flat);
  *valid = AND(*valid, far_enough(flat, y));
}

FN void double_sphere_image(LENS_CONSTANTS lens, F x, F y, F z, F* u, F* v, I* valid) {
  const real alpha = lens->alpha;
  const F r = sqrt(x * x + y * y + z * z);
  const I ok = AND(r > CAMERA_NEAR, z > lens->cos_min * r);
  const F shifted = fma(r, (F)lens->xi, z);
  const F second = sqrt(x * x + y * y + shifted * shifted);
  const F inv = R(1.0) / SEL(ok, alpha * second + (R(1.0) - alpha) * shifted, (F)R(1.0));
  *u = x * inv;
  *v = y * inv;
  *valid = AND(*valid, ok);
}

/// Extended unified camera model.
FN void eucm_image(LENS_CONSTANTS lens, F x, F y, F z, F* u, F* v, I* valid) {
  const real alpha = lens->alpha;
  const F xy2 = fma(x, x, y * y);
  const F r = sqrt(fma(z, z, xy2));
  const I ok = AND(r > CAMERA_NEAR, z > lens->cos_min * r);
  const F d = sqrt(fma((F)lens->beta, xy2, z * z));
  const F inv = R(1.0) / SEL(ok, alpha * d + (R(1.0) - alpha) * z, (F)R(1.0));
  *u = x * inv;
  *v = y * inv;
  *valid = AND(*valid, ok);
}

#endif

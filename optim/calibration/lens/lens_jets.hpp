#pragma once
// cl/math/camera.h compiled for automatic differentiation, so that the differentiated code is the code of
// device and host. F is a Ceres Jet, a mask is an int. Included only by this folder's sources, and not together
// with host/core/sensors/lens/lens_forward.hpp.
#include <Eigen/Core>
#include <algorithm>
#include <ceres/jet.h>

#include "cl/shared/sensor_constants.h"
#include "host/core/sensors/lens.hpp"

namespace simuli::calibration::lens_jets {

inline constexpr int kDerivatives = 20;  // 12 lens parameters, fx fy cx cy, a point
using F = ceres::Jet<double, kDerivatives>;
using real = F;
using I = int;
inline F atan2_lanes(const F& y, const F& x) { return ceres::atan2(y, x); }
inline void sincos_lanes(const F& x, F* sine, F* cosine) {
  *sine = ceres::sin(x);
  *cosine = ceres::cos(x);
}

#include "host/core/sensors/lens/lens_text.hpp"

using Constants = shared::LensConstants<F>;

/// Constants of a lens, without derivatives.
inline Constants constants_of(const Lens& lens) {
  const auto& from = lens.constants();
  Constants to{};
  to.cos_min = F(from.cos_min);
  to.angle_max = F(from.angle_max);
  to.radius2_max = F(from.radius2_max);
  to.radius_max = F(from.radius_max);
  const auto copy = [](const auto& values, F* out) {
    std::transform(std::begin(values), std::end(values), out, [](double value) { return F(value); });
  };
  copy(from.distortion, to.distortion);
  copy(from.polynomial, to.polynomial);
  copy(from.linear, to.linear);
  to.xi = F(from.xi);
  to.alpha = F(from.alpha);
  to.beta = F(from.beta);
  to.bend = F(from.bend);
  to.bend_cos_min = F(from.bend_cos_min);
  copy(from.bend_horizontal, to.bend_horizontal);
  copy(from.bend_vertical, to.bend_vertical);
  copy(from.bend_back_horizontal, to.bend_back_horizontal);
  copy(from.bend_back_vertical, to.bend_back_vertical);
  return to;
}

/// Image of a point in front of a lens of `kind`; false without one.
inline bool project(LensKind kind, const Constants& lens, F x, F y, F z, F& u, F& v) {
  const Constants* const k = &lens;
  int valid = 1;
  if (k->bend != F(SIM_BEND_NONE)) bend_point(k, k->bend == F(SIM_BEND_BACKWARD), &x, &y, &z, &valid);
  switch (kind) {
    case LensKind::kPinhole:
      pinhole_image(x, y, z, &u, &v, &valid);
      break;
    case LensKind::kOpencvPinhole:
      opencv_pinhole_image(k, x, y, z, &u, &v, &valid);
      break;
    case LensKind::kOpencvFisheye:
      opencv_fisheye_image(k, x, y, z, &u, &v, &valid);
      break;
    case LensKind::kFtheta:
      ftheta_image(k, x, y, z, &u, &v, &valid);
      break;
    case LensKind::kFthetaInverse:
      ftheta_inverse_image(k, x, y, z, &u, &v, &valid);
      break;
    case LensKind::kMei:
      mei_image(k, x, y, z, &u, &v, &valid);
      break;
    case LensKind::kEquirectangular:
      equirectangular_image(x, y, z, &u, &v, &valid);
      break;
    case LensKind::kDoubleSphere:
      double_sphere_image(k, x, y, z, &u, &v, &valid);
      break;
    case LensKind::kEucm:
      eucm_image(k, x, y, z, &u, &v, &valid);
      break;
  }
  return valid != 0;
}

}  // namespace simuli::calibration::lens_jets

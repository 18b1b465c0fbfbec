#include "io/export/ftheta_camera.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace simuli {
namespace {

constexpr double kFirstCentre = 0.5;

double value_at(const std::array<double, 6>& polynomial, double x) {
  double sum = 0.0;
  for (std::size_t i = polynomial.size(); i-- > 0;) sum = sum * x + polynomial[i];
  return sum;
}

/// Returns the polynomial without degree 0 that inverts another one over [0, last], by least squares.
std::array<double, 6> inverse_of(const std::array<double, 6>& polynomial, double last) {
  constexpr int kSamples = 256, kDegrees = 5;
  Eigen::MatrixXd powers(kSamples, kDegrees);
  Eigen::VectorXd arguments(kSamples);
  const double farthest = value_at(polynomial, last);
  for (int i = 0; i < kSamples; ++i) {
    arguments[i] = last * (i + 1) / kSamples;
    const double share = value_at(polynomial, arguments[i]) / farthest;
    for (int k = 0; k < kDegrees; ++k) powers(i, k) = std::pow(share, k + 1);
  }
  const Eigen::VectorXd solution = powers.colPivHouseholderQr().solve(arguments);
  std::array<double, 6> out{};
  for (int k = 0; k < kDegrees; ++k)
    out[static_cast<std::size_t>(k + 1)] = solution[k] / std::pow(farthest, k + 1);
  return out;
}

/// Returns the largest distance of the picture's corners from the principal point, px.
double farthest_corner(const Camera& camera) {
  return std::hypot(std::max(camera.cx, camera.width - camera.cx),
                    std::max(camera.cy, camera.height - camera.cy));
}

/// Returns the argument, at most `last`, for which the polynomial, which increases from 0, equals `value`.
double argument_of(const std::array<double, 6>& polynomial, double value, double last) {
  constexpr int kSteps = 1000;
  for (int i = 1; i <= kSteps; ++i) {
    const double x = last * i / kSteps;
    if (value_at(polynomial, x) >= value ||
        value_at(polynomial, x) <= value_at(polynomial, last * (i - 1) / kSteps)) {
      return x;
    }
  }
  return last;
}

}  // namespace

FthetaCamera ftheta_of(const Camera& camera) {
  FthetaCamera out;
  out.is_inverse = camera.lens.kind() == LensKind::kFthetaInverse;
  const std::vector<double>& all = camera.lens.parameters();
  std::array<double, 6>& own = out.is_inverse ? out.pixels_to_angle : out.angle_to_pixels;
  double scale = out.is_inverse ? 1.0 : camera.fy;
  for (std::size_t i = 0; i < 5; ++i) {
    if (out.is_inverse) scale /= camera.fy;
    own[i + 1] = all[i] * scale;
  }
  const double aspect = camera.fx / camera.fy;
  out.linear_cde = {all[5] * aspect, all[6] * aspect, all[7]};
  out.max_angle_rad = all[8];
  out.principal_point = {camera.cx - kFirstCentre, camera.cy - kFirstCentre};
  const double corner = farthest_corner(camera);
  if (out.is_inverse) {
    out.angle_to_pixels = inverse_of(own, corner);
  } else {
    out.pixels_to_angle = inverse_of(own, argument_of(own, corner, out.max_angle_rad));
  }
  return out;
}

}  // namespace simuli

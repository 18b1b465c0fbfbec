#include "host/core/base/pose.hpp"

#include <Eigen/SVD>
#include <cmath>
#include <fmt/format.h>

#include "host/core/base/error.hpp"

namespace simuli {

Pose Pose::inverse() const {
  const Eigen::Quaterniond b_from_a = rotation.conjugate();
  return {b_from_a, -(b_from_a * translation)};
}

void Pose::check(const std::string& what) const {
  const bool is_near = translation.allFinite() && translation.cwiseAbs().maxCoeff() <= kFarthestInScene_m;
  if (is_near && std::abs(rotation.norm() - 1.0) < 1e-3) return;
  throw Error(ErrorKind::kNumeric,
              fmt::format("pose of {}: found a place {} m from the origin and a quaternion of norm {}, "
                          "allowed up to {} m and 1",
                          what,
                          translation.norm(),
                          rotation.norm(),
                          kFarthestInScene_m));
}

Eigen::Matrix4d Pose::matrix() const {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = rotation.toRotationMatrix();
  m.topRightCorner<3, 1>() = translation;
  return m;
}

Pose Pose::from_matrix(const Eigen::Matrix<double, 3, 4>& a_from_b) {
  if (!a_from_b.allFinite()) throw_input_error("pose", "matrix", "NaN or Inf", "finite numbers");
  // Calibration files print 6 or 7 digits: uses the nearest rotation.
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(a_from_b.leftCols<3>(),
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d rotation = svd.matrixU() * svd.matrixV().transpose();
  const Eigen::Vector3d scale = svd.singularValues();
  if (!(rotation.determinant() > 0.0 && scale(0) < 1.01 && scale(2) > 0.99)) {
    throw_input_error("pose",
                      "rotation",
                      fmt::format("determinant {:.4g}, scales {:.4g} to {:.4g}",
                                  a_from_b.leftCols<3>().determinant(),
                                  scale(2),
                                  scale(0)),
                      "a rotation within 1 %");
  }
  return {Eigen::Quaterniond(rotation).normalized(), a_from_b.col(3)};
}

Pose operator*(const Pose& a_from_b, const Pose& b_from_c) {
  return {(a_from_b.rotation * b_from_c.rotation).normalized(),
          a_from_b.rotation * b_from_c.translation + a_from_b.translation};
}

Eigen::Vector3d operator*(const Pose& a_from_b, const Eigen::Vector3d& p_b) {
  return a_from_b.rotation * p_b + a_from_b.translation;
}

/// Equals a.slerp(u, b). For the small rotations within an exposure or a revolution it uses series of the
/// sines, exact to rounding, instead of an arc cosine and three sines.
static Eigen::Quaterniond slerp(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b, double u) {
  constexpr double kNear = 1e-3;  // of the squared chord: 3.6 degrees of rotation
  const double sign = a.dot(b) < 0.0 ? -1.0 : 1.0;
  const double chord2 = (a.coeffs() - sign * b.coeffs()).squaredNorm();
  if (!(chord2 < kNear)) return a.slerp(u, b);
  // arc = 2 asin(chord / 2); a weight is sin(w arc) / sin(arc).
  const double arc2 = chord2 * (1.0 + chord2 * (1.0 / 12.0 + chord2 * (1.0 / 90.0 + chord2 / 560.0)));
  const auto sinc = [](double x2) {
    return 1.0 - x2 / 6.0 * (1.0 - x2 / 20.0 * (1.0 - x2 / 42.0 * (1.0 - x2 / 72.0)));
  };
  const double whole = 1.0 / sinc(arc2);
  const auto weight = [&](double w) { return w * sinc(w * w * arc2) * whole; };
  return Eigen::Quaterniond(Eigen::Vector4d(weight(1.0 - u) * a.coeffs() + (weight(u) * sign) * b.coeffs()));
}

Pose interpolate(const Pose& a, const Pose& b, double u) {
  return {slerp(a.rotation, b.rotation, u), (1.0 - u) * a.translation + u * b.translation};
}

}  // namespace simuli

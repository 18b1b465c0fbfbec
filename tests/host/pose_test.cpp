#include "host/core/base/pose.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "tests/host/expect_error.hpp"

namespace simuli {
namespace pose_test {

// A handful of double operations on numbers of size 1 to 100.
constexpr double kRounding = 1e-12;

Pose make_pose(double angle_rad, const Eigen::Vector3d& axis, const Eigen::Vector3d& translation) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, axis.normalized())), translation};
}

TEST(Pose, ActsAsItsMatrix) {
  const Pose a_from_b = make_pose(0.7, {1, 2, 3}, {4, -5, 6});
  const Eigen::Vector3d p_b(0.3, -0.2, 9.0);
  const Eigen::Vector4d expected = a_from_b.matrix() * p_b.homogeneous();
  EXPECT_LT((a_from_b * p_b - expected.head<3>()).norm(), kRounding);
}

TEST(Pose, ProductAppliesTheRightFactorFirst) {
  const Pose a_from_b = make_pose(0.7, {1, 2, 3}, {4, -5, 6});
  const Pose b_from_c = make_pose(-2.0, {0, 1, -1}, {1, 1, 8});
  const Eigen::Vector3d p_c(2, 3, 5);
  EXPECT_LT(((a_from_b * b_from_c) * p_c - a_from_b * (b_from_c * p_c)).norm(), kRounding);
}

TEST(Pose, InverseUndoes) {
  const Pose a_from_b = make_pose(2.5, {-1, 0.2, 3}, {40, -5, 6});
  const Eigen::Vector3d p_b(1, 2, 3);
  EXPECT_LT((a_from_b.inverse() * (a_from_b * p_b) - p_b).norm(), 100 * kRounding);
  EXPECT_LT(((a_from_b * a_from_b.inverse()).matrix() - Eigen::Matrix4d::Identity()).norm(), 100 * kRounding);
}

TEST(Pose, FromMatrixTakesTheNearestRotation) {
  const Pose expected = make_pose(1.1, {3, 1, -2}, {7, 8, 9});
  Eigen::Matrix<double, 3, 4> printed = expected.matrix().topRows<3>();
  // Keeps six digits, as a calibration file does.
  for (Eigen::Index i = 0; i < printed.size(); ++i) {
    printed.data()[i] = std::round(printed.data()[i] * 1e6) / 1e6;
  }
  const Pose read = Pose::from_matrix(printed);
  EXPECT_LT(read.rotation.angularDistance(expected.rotation), 2e-6);  // the digits that were cut off
  const Eigen::Matrix3d r = read.rotation.toRotationMatrix();
  EXPECT_LT((r * r.transpose() - Eigen::Matrix3d::Identity()).norm(), kRounding);
  EXPECT_LT((read.translation - Eigen::Vector3d(7, 8, 9)).norm(), kRounding);
}

TEST(Pose, FromMatrixRefusesWhatIsNoRotation) {
  Eigen::Matrix<double, 3, 4> mirrored = Eigen::Matrix<double, 3, 4>::Identity();
  mirrored(1, 1) = -1.0;
  expect_error(ErrorKind::kInput, "determinant", [&] { (void)Pose::from_matrix(mirrored); });
  Eigen::Matrix<double, 3, 4> scaled = Eigen::Matrix<double, 3, 4>::Identity();
  scaled(2, 2) = 1.1;
  expect_error(ErrorKind::kInput, "rotation within 1 %", [&] { (void)Pose::from_matrix(scaled); });
  scaled(2, 2) = std::nan("");
  expect_error(ErrorKind::kInput, "NaN or Inf", [&] { (void)Pose::from_matrix(scaled); });
}

TEST(Pose, InterpolationTurnsAtConstantRate) {
  const Pose a = make_pose(0.2, {0, 0, 1}, {0, 0, 0});
  const Pose b = make_pose(1.4, {0, 0, 1}, {10, 0, 0});
  for (const double u : {0.0, 0.25, 0.5, 1.0}) {
    const Pose p = interpolate(a, b, u);
    const Eigen::Quaterniond expected(Eigen::AngleAxisd(0.2 + 1.2 * u, Eigen::Vector3d::UnitZ()));
    EXPECT_LT(p.rotation.angularDistance(expected), 1e-7) << u;  // acos near 1 loses half the digits
    EXPECT_LT((p.translation - Eigen::Vector3d(10 * u, 0, 0)).norm(), kRounding) << u;
  }
}

TEST(Pose, InterpolationMovesTheSensorCentreOnAStraightLine) {
  // Interpolating the inverse poses would bend this path: far from the origin, turning.
  const Pose world_from_sensor_a = make_pose(0.0, {0, 0, 1}, {100, 0, 0});
  const Pose world_from_sensor_b = make_pose(0.5, {0, 0, 1}, {100, 2, 0});
  const Pose middle = interpolate(world_from_sensor_a, world_from_sensor_b, 0.5);
  EXPECT_LT((middle.translation - Eigen::Vector3d(100, 1, 0)).norm(), kRounding);
  const Pose bent = interpolate(world_from_sensor_a.inverse(), world_from_sensor_b.inverse(), 0.5).inverse();
  EXPECT_GT((bent.translation - Eigen::Vector3d(100, 1, 0)).norm(), 1.0);
}

TEST(Pose, InterpolationTakesTheShorterArc) {
  const Pose a = make_pose(0.1, {0, 0, 1}, {0, 0, 0});
  Pose b = make_pose(0.3, {0, 0, 1}, {0, 0, 0});
  b.rotation.coeffs() *= -1.0;  // the same rotation
  const Eigen::Quaterniond expected(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitZ()));
  EXPECT_LT(interpolate(a, b, 0.5).rotation.angularDistance(expected), 1e-7);
}

/// Small rotations use a series, others sines; shutters also use values slightly outside of [0, 1].
TEST(Pose, InterpolatesAlongTheArcHoweverShortItIs) {
  const Pose a = make_pose(1.3, {1, -2, 0.5}, {4, -5, 6});
  for (const double turned_rad : {0.0, 1e-12, 1e-6, 1e-3, 0.05, 0.0632, 0.0633, 0.2, 1.5, 3.0}) {
    const Eigen::Quaterniond near(Eigen::AngleAxisd(turned_rad, Eigen::Vector3d(3, 1, 2).normalized()));
    for (const double sign : {1.0, -1.0}) {
      Pose b{a.rotation * near, a.translation};
      b.rotation.coeffs() *= sign;  // the same rotation
      for (const double u : {-0.25, 0.0, 0.3, 0.5, 0.9, 1.0, 1.25}) {
        const Eigen::Quaterniond got = interpolate(a, b, u).rotation;
        const Eigen::Quaterniond along =
            a.rotation *
            Eigen::Quaterniond(Eigen::AngleAxisd(u * turned_rad, Eigen::Vector3d(3, 1, 2).normalized()));
        EXPECT_LT((got.toRotationMatrix() - along.toRotationMatrix()).norm(), kRounding)
            << turned_rad << " " << sign << " " << u;
        EXPECT_NEAR(got.norm(), 1.0, kRounding);
      }
    }
  }
}

}  // namespace pose_test
}  // namespace simuli

#pragma once
// Rigid transforms. Quaternion order is (w, x, y, z) everywhere on disk and on the device.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>

namespace simuli {

/// Larger than coordinates of any map projection of the Earth.
inline constexpr double kFarthestPosition_m = 1e8;
/// Limit of distances from the scene's origin, where single precision resolves 1 m.
inline constexpr double kFarthestInScene_m = 1e7;

/// A rigid transform `a_from_b`: p_a = a_from_b * p_b. Rotation is a unit quaternion, translation in
/// metres is the origin of frame b in frame a (for world_from_sensor: the sensor centre).
struct Pose {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  [[nodiscard]] Pose inverse() const;
  [[nodiscard]] Eigen::Matrix4d matrix() const;
  /// Converts the upper 3x4 of a matrix; uses the rotation nearest to the rotation block. Throws Error{kInput}
  /// for a block that is no rotation (reflected, scaled, not finite).
  static Pose from_matrix(const Eigen::Matrix<double, 3, 4>& a_from_b);
  /// Throws Error{kNumeric} with `what` ("the sensor") unless the translation is within kFarthestInScene_m and
  /// the quaternion's norm within 1e-3 of 1.
  void check(const std::string& what) const;
};

[[nodiscard]] Pose operator*(const Pose& a_from_b, const Pose& b_from_c);
[[nodiscard]] Eigen::Vector3d operator*(const Pose& a_from_b, const Eigen::Vector3d& p_b);

/// Interpolates two world_from_sensor poses: slerp of the rotation (shorter arc), lerp of the sensor centre
/// (METHOD section 3: interpolating the inverse would bend the path). u = 0 gives a, u = 1 gives b.
[[nodiscard]] Pose interpolate(const Pose& a, const Pose& b, double u);

}  // namespace simuli

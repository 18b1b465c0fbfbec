#include "host/core/scene/mounting.hpp"

#include <algorithm>
#include <cmath>

#include "host/core/base/angles.hpp"

namespace simuli {
namespace {

const Pose kLevelFromCamera{kForwardFromCamera, Eigen::Vector3d::Zero()};

}  // namespace

Pose Mounting::rig_from_lidar() const {
  const auto turn = [](double angle_deg, const Eigen::Vector3d& axis) {
    return Eigen::AngleAxisd(angle_deg * kDegree, axis);
  };
  return {turn(yaw_deg, Eigen::Vector3d::UnitZ()) * turn(pitch_deg, Eigen::Vector3d::UnitY()) *
              turn(roll_deg, Eigen::Vector3d::UnitX()),
          position_m};
}

Pose Mounting::rig_from_camera() const { return rig_from_lidar() * kLevelFromCamera; }

Mounting Mounting::of_lidar(const Pose& rig_from_lidar) {
  constexpr double kUpright = 1.0 - 1e-12;  // sine of the pitch above which roll and yaw are not distinguishable
  const Eigen::Matrix3d r = rig_from_lidar.rotation.normalized().toRotationMatrix();
  Mounting mounting{.position_m = rig_from_lidar.translation};
  mounting.pitch_deg = std::asin(std::clamp(-r(2, 0), -1.0, 1.0)) / kDegree;
  if (std::abs(r(2, 0)) > kUpright) {
    mounting.roll_deg = std::atan2(-r(1, 2), r(1, 1)) / kDegree;
  } else {
    mounting.roll_deg = std::atan2(r(2, 1), r(2, 2)) / kDegree;
    mounting.yaw_deg = std::atan2(r(1, 0), r(0, 0)) / kDegree;
  }
  return mounting;
}

Mounting Mounting::of_camera(const Pose& rig_from_camera) {
  return of_lidar(rig_from_camera * kLevelFromCamera.inverse());
}

}  // namespace simuli

#pragma once
// Mounting of a sensor on its rig, as position and angles.
#include <Eigen/Core>

#include "host/core/base/pose.hpp"

namespace simuli {

/// Rotates camera axes (x right, y down, z forward) to those of rigs and LiDARs (x forward, y left, z up).
inline const Eigen::Quaterniond kForwardFromCamera{0.5, -0.5, 0.5, -0.5};

/// In the rig's frame: x forward, y left, z up. With zero angles a LiDAR's axes are the rig's, and a camera
/// looks along the rig's x, upright. rotation = Rz(yaw) Ry(pitch) Rx(roll): rotates by roll about x, then pitch
/// about y, then yaw about z of the rig.
struct Mounting {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  double roll_deg = 0.0;   // positive: left side up
  double pitch_deg = 0.0;  // positive: looks down
  double yaw_deg = 0.0;    // positive: looks to the left

  [[nodiscard]] Pose rig_from_lidar() const;
  [[nodiscard]] Pose rig_from_camera() const;
  /// Converts from poses. Straight up or down the yaw is 0.
  [[nodiscard]] static Mounting of_lidar(const Pose& rig_from_lidar);
  [[nodiscard]] static Mounting of_camera(const Pose& rig_from_camera);
};

}  // namespace simuli

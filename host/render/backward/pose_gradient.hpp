#pragma once
// The gradient of a sensor's pose (METHOD section 7).
#include <Eigen/Core>
#include <utility>

#include "host/scene/pose.hpp"

namespace simuli {

/// A small change of a frame's pose: the sensor's centre moves by `translation`, given in the axes that the
/// sensor has half-way through the frame, and at each time the sensor turns by `rotation` (rad) in its own
/// axes.
struct PoseTangent {
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();
};
using PoseGradient = PoseTangent;

/// The poses of a frame at its start and end, changed by `tangent`.
[[nodiscard]] std::pair<Pose, Pose> moved_by(const PoseTangent& tangent, const Pose& start, const Pose& end);

}  // namespace simuli

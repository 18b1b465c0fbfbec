#pragma once
// Two cars for tests of actors.
#include <vector>

#include "host/core/scene/actor.hpp"

namespace simuli::test {

inline Pose pose_of(const Eigen::Vector3d& position, double yaw, double roll = 0.0) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                             Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX())),
          position};
}

/// Returns two cars ahead of the sensor that move by `step_m` and rotate by `turn_rad` during the frame.
inline std::vector<ActorView> cars(double step_m, double turn_rad) {
  const auto from_to = [](const Pose& start, const Eigen::Vector3d& step, double turn) {
    Pose end = start;
    end.translation += step;
    end.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(turn, Eigen::Vector3d(0.1, 0.2, 0.9).normalized())) *
                   start.rotation;
    return ActorView{true, start, end};
  };
  return {from_to(pose_of({6.5, 2.0, -0.4}, 0.3, 0.02), {step_m, 0.1 * step_m, 0.0}, turn_rad),
          from_to(pose_of({9.0, -2.5, 0.2}, -2.0), {-0.8 * step_m, 0.3 * step_m, 0.02}, -turn_rad)};
}

}  // namespace simuli::test

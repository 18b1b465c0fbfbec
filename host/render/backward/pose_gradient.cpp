#include "host/render/backward/pose_gradient.hpp"

#include <Eigen/Geometry>

namespace simuli {

std::pair<Pose, Pose> moved_by(const PoseTangent& tangent, const Pose& start, const Pose& end) {
  const Eigen::Quaterniond half_way = start.rotation.slerp(0.5, end.rotation);
  const Eigen::Vector3d step = half_way * tangent.translation;
  const double angle = tangent.rotation.norm();
  const Eigen::Quaterniond turn(angle > 0.0 ? Eigen::AngleAxisd(angle, tangent.rotation / angle)
                                            : Eigen::AngleAxisd::Identity());
  std::pair<Pose, Pose> moved{start, end};
  for (Pose* pose : {&moved.first, &moved.second}) {
    pose->translation += step;
    pose->rotation = pose->rotation * turn;
  }
  return moved;
}

}  // namespace simuli

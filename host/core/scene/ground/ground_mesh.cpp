#include "host/core/scene/ground/ground_mesh.hpp"

#include "host/core/scene/moment.hpp"

namespace simuli {

GroundMap ground_of(const Scene& scene) {
  const GaussianSet still = background_of(scene, SetKind::kLidar);
  Eigen::Matrix3Xf solid(3, still.size());
  Eigen::Index count = 0;
  for (Eigen::Index i = 0; i < still.size(); ++i) {
    if (still.opacity_logit()(i) >= 0.0F) solid.col(count++) = still.mean().row(i).transpose();
  }
  GroundMap map;
  map.add(solid.leftCols(count));
  map.finish();
  return map;
}

TriangleMesh ground_mesh(const GroundMap& ground, const Scene& scene, const Trajectory& world_from_rig) {
  std::vector<Eigen::Vector2d> below;
  for (const TimedPose& pose : world_from_rig.poses()) {
    below.emplace_back((pose.pose.translation - scene.origin).head<2>());
  }
  return ground.mesh(below);
}

}  // namespace simuli

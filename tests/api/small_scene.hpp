#pragma once
// A scene that is small enough to tell what its frames must be.
#include <filesystem>
#include <gtest/gtest.h>
#include <simuli/simuli.hpp>
#include <stdlib.h>
#include <string>

namespace simuli {

/// One particle 5 m ahead of a rig that drives 1 m along x in a second, its world around `origin`.
inline SceneFile small_scene(const Eigen::Vector3d& origin = Eigen::Vector3d::Zero()) {
  SceneFile file;
  Scene& scene = file.scene;
  scene.name = "small";
  scene.origin = origin;
  scene.camera_filter_px2 = kSplatVariance_px2;  // its few pixels show the particle whole
  scene.camera = GaussianSet(SetKind::kCamera, 0, 1);
  scene.lidar = GaussianSet(SetKind::kLidar, 0, 1);
  for (GaussianSet* set : {&scene.camera, &scene.lidar}) {
    set->mean().row(0) << 5.0F, 0.0F, 0.0F;
    set->log_scale().setConstant(-1.0F);
    set->rotation()(0, 0) = 1.0F;
    set->opacity_logit().setConstant(6.0F);
    set->sh(0).row(0) << 1.0F, -1.0F, 0.0F;
  }
  scene.lidar.sh(0).row(0) << 0.5F, 20.0F, -20.0F;
  Camera camera{"front", 16, 12, 12.0, 12.0, 8.0, 6.0};
  const Eigen::Quaterniond forward(0.5, -0.5, 0.5, -0.5);  // camera axes on a rig
  file.cameras = {{camera, {forward, Eigen::Vector3d::Zero()}}};
  file.lidars = {{builtin_lidar("velodyne_vlp16"), {}}};
  const Pose start{Eigen::Quaterniond::Identity(), origin};
  const Pose end{Eigen::Quaterniond::Identity(), origin + Eigen::Vector3d(1.0, 0.0, 0.0)};
  file.world_from_rig = Trajectory({{0.0, start}, {1.0, end}});
  return file;
}

/// The same, and an actor "car" of one more particle, 8 m ahead and 2 m to the left.
inline SceneFile scene_with_actor() {
  SceneFile file = small_scene();
  Scene& scene = file.scene;
  for (GaussianSet* set : {&scene.camera, &scene.lidar}) {
    const Eigen::MatrixXf one = set->params;
    set->params.resize(2, one.cols());
    set->params << one, one;
    set->mean().row(1).setZero();
    set->actor = {0, 1};
  }
  Actor car{"car", "car", {4.0, 2.0, 1.5}, {}};
  const Pose there{Eigen::Quaterniond::Identity(), {8.0, 2.0, 0.0}};
  car.track = {{0.0, there}, {1.0, there}};
  scene.actors = {car};
  return file;
}

class ScratchTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::temp_directory_path() / "simuli_api_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_;
};

}  // namespace simuli

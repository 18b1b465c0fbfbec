#include <algorithm>
#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <string>
#include <vector>

#include "host/api/simuli.h"
#include "host/api/simuli.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

/// One particle 5 m ahead of a rig that drives 1 m along x in a second.
SceneFile small_scene() {
  SceneFile file;
  Scene& scene = file.scene;
  scene.name = "small";
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
  const Pose end{Eigen::Quaterniond::Identity(), {1.0, 0.0, 0.0}};
  file.world_from_rig = Trajectory({{0.0, {}}, {1.0, end}});
  return file;
}

class CApi : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "simuli_c_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    write_scene(folder_ / "small.scene", small_scene());
    ASSERT_EQ(simuli_device_open(nullptr, &device_), SIMULI_OK) << simuli_error();
    const std::string path = (folder_ / "small.scene").string();
    ASSERT_EQ(simuli_scene_open(device_, path.c_str(), &scene_), SIMULI_OK) << simuli_error();
  }
  void TearDown() override {
    simuli_scene_close(scene_);
    simuli_device_close(device_);
    fs::remove_all(folder_);
  }
  static void expect_error(simuli_status found, simuli_status expected, const std::string& part) {
    EXPECT_EQ(found, expected);
    EXPECT_NE(std::string(simuli_error()).find(part), std::string::npos) << simuli_error();
  }

  fs::path folder_;
  simuli_device* device_ = nullptr;
  simuli_scene* scene_ = nullptr;
};

TEST_F(CApi, ListsSensorsAndRendersThem) {
  ASSERT_EQ(simuli_scene_sensor_count(scene_), 2U);
  simuli_sensor camera{}, lidar{};
  ASSERT_EQ(simuli_scene_sensor(scene_, 0, &camera), SIMULI_OK);
  ASSERT_EQ(simuli_scene_sensor(scene_, 1, &lidar), SIMULI_OK);
  EXPECT_STREQ(camera.name, "front");
  EXPECT_EQ(camera.is_camera, 1);
  EXPECT_EQ(camera.columns * camera.rows, 16U * 12U);
  EXPECT_STREQ(lidar.name, "velodyne_vlp16");
  EXPECT_EQ(lidar.rows, 16U);

  simuli_shot shot{};
  ASSERT_EQ(simuli_scene_shot(scene_, "front", 0.5, 0.5, &shot), SIMULI_OK) << simuli_error();
  EXPECT_NEAR(shot.world_from_sensor_start.position_m[0], 0.5, 1e-9);
  std::vector<float> rgb(std::size_t{3} * 16 * 12);
  ASSERT_EQ(simuli_render_camera(scene_, "front", &shot, rgb.data(), rgb.size()), SIMULI_OK);
  const std::size_t middle = 3 * (6 * 16 + 8);
  EXPECT_GT(rgb[middle], 0.6F);
  EXPECT_LT(rgb[middle + 1], 0.4F);

  ASSERT_EQ(simuli_scene_shot(scene_, lidar.name, 0.0, 0.1, &shot), SIMULI_OK);
  const std::size_t rays = lidar.rows * lidar.columns;
  std::vector<float> range(rays), points(3 * rays);
  const simuli_lidar_frame frame{range.data(), nullptr, nullptr, points.data(), rays};
  ASSERT_EQ(simuli_render_lidar(scene_, lidar.name, &shot, &frame), SIMULI_OK) << simuli_error();
  const auto farthest = std::max_element(range.begin(), range.end()) - range.begin();
  EXPECT_GT(range[static_cast<std::size_t>(farthest)], 3.0F);
  for (std::size_t i = 0; i < rays; ++i) {
    if (range[i] > 0.0F) {
      EXPECT_NEAR(points[3 * i], 5.0F, 1.5F) << i;
    }
  }
}

TEST_F(CApi, MountsAnotherLidar) {
  const simuli_pose mount{{0.0, 0.0, 0.2}, {2.0, 0.0, 0.0, 0.0}};
  ASSERT_EQ(simuli_scene_add_lidar(scene_, "hesai_xt32", &mount), SIMULI_OK) << simuli_error();
  simuli_sensor sensor{};
  ASSERT_EQ(simuli_scene_sensor(scene_, 2, &sensor), SIMULI_OK);
  EXPECT_STREQ(sensor.name, "hesai_xt32");
  EXPECT_EQ(sensor.rig_from_sensor.rotation_wxyz[0], 1.0);
  expect_error(simuli_scene_add_lidar(scene_, "hesai_xt32", &mount), SIMULI_USAGE, "already");
  expect_error(simuli_scene_add_lidar(scene_, "hesai_xt", &mount), SIMULI_USAGE, "hesai_xt32");
}

TEST_F(CApi, SaysWhatIsWrong) {
  simuli_scene* none = nullptr;
  expect_error(simuli_scene_open(device_, "/nowhere", &none), SIMULI_INPUT, "/nowhere");
  EXPECT_EQ(none, nullptr);
  simuli_device* device = nullptr;
  expect_error(simuli_device_open("no such device", &device), SIMULI_DEVICE, "no such device");
  expect_error(simuli_scene_open(nullptr, "x", &none), SIMULI_USAGE, "device: found NULL");
  simuli_shot shot{};
  expect_error(simuli_scene_shot(scene_, "rear", 0.0, 0.0, &shot), SIMULI_USAGE, "rear");
  expect_error(simuli_scene_shot(scene_, "front", 9.0, 9.0, &shot), SIMULI_INPUT, "9");
  float one = 0.0F;
  expect_error(simuli_render_camera(scene_, "front", &shot, &one, 1), SIMULI_USAGE, "found 1, allowed 576");
  std::vector<float> rgb(576);
  expect_error(simuli_render_camera(scene_, "front", &shot, rgb.data(), 576), SIMULI_USAGE, "quaternion");
  simuli_sensor sensor{};
  expect_error(simuli_scene_sensor(scene_, 2, &sensor), SIMULI_USAGE, "index: found 2");
  simuli_scene_close(nullptr);
  simuli_device_close(nullptr);
}

}  // namespace
}  // namespace simuli

#include "host/render/scene/scene_on_device.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <utility>

#include "host/base/error.hpp"
#include "host/render/scene/renderer.hpp"

namespace simuli {
namespace {

Scene one_particle() {
  Scene scene;
  scene.origin = {100.0, 0.0, 0.0};
  scene.camera = GaussianSet(SetKind::kCamera, 0, 1);
  scene.camera.mean().row(0) << 0.0F, 0.0F, 5.0F;
  scene.camera.log_scale().setConstant(-1.0F);
  scene.camera.rotation()(0, 0) = 1.0F;
  scene.camera.opacity_logit().setConstant(6.0F);
  scene.camera.sh(0).row(0) << 1.0F, -1.0F, 0.0F;
  return scene;
}

const Camera kCamera{"any", 16, 12, 12.0, 12.0, 8.0, 6.0};
const Sensor kSensor(kCamera);
const Shot kShot = Shot::at({Eigen::Quaterniond::Identity(), {100.0, 0.0, 0.0}}, 0.0);

TEST(SceneOnDevice, IsTheRendererWithEverythingInPlace) {
  const Device device = Device::best();
  SceneOnDevice scene(device, one_particle());
  const Image image = scene.render(kSensor, kShot).image();

  Renderer renderer(device, options_of(Quality::kBalanced));
  const ParticleBuffers particles(device, one_particle().camera, Precision::kFloat);
  // The rays are a temporary: the renderer keeps what results() needs.
  renderer.render(particles, SensorRays(device, kCamera, renderer.options()), View{});
  EXPECT_EQ(image.data, picture_of(renderer.results(), kCamera).data);
  EXPECT_GT(image.at(8, 6, 0), 0.6F);
}

TEST(SceneOnDevice, TellsSensorsApart) {
  SceneOnDevice made(Device::best(), one_particle());
  SceneOnDevice scene = std::move(made);
  const Image image = scene.render(kSensor, kShot).image();
  Camera wider = kCamera;
  wider.fx = 6.0;
  EXPECT_NE(scene.render(Sensor(wider), kShot).image().data, image.data);
  wider.width = 20;
  EXPECT_EQ(scene.render(Sensor(wider), kShot).image().width, 20);
  EXPECT_EQ(scene.render(kSensor, kShot).image().data, image.data);
  for (int i = 0; i < 10; ++i) {  // more than are kept
    wider.fy = 7.0 + i;
    (void)scene.render(Sensor(wider), kShot).image();
  }
  EXPECT_EQ(scene.render(kSensor, kShot).image().data, image.data);
  wider.fy = -1.0;
  EXPECT_THROW((void)scene.render(Sensor(wider), kShot).image(), Error);
}

TEST(SceneOnDevice, PutsPointsIntoTheWorld) {
  Lidar lidar;
  lidar.name = "two";
  lidar.rows = {{}, {}};
  lidar.rows[1].vertical_offset = -0.5;
  lidar.columns = 1;
  lidar.azimuth_span = 1.0;
  LidarFrame frame;
  frame.rays = {2, 1, {0.0F, 0.0F}, {0.0F, 0.0F}, {0.0F, 0.5F}};
  frame.range = {2.0F, 3.0F};
  EXPECT_EQ(frame.returns(), 2);
  Shot shot = kShot;
  shot.world_from_sensor_end.translation.y() = 1.0;
  const auto points = world_points(lidar, frame, shot);
  EXPECT_LT((points[0] - Eigen::Vector3d(102.0, 0.0, 0.0)).norm(), 1e-9);
  EXPECT_LT((points[1] - Eigen::Vector3d(103.0, 0.5, -0.5)).norm(), 1e-9);
}

}  // namespace
}  // namespace simuli

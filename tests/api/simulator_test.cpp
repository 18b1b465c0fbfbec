#include "host/render/scene/simulator.hpp"

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
const Shot kShot = Shot::at({Eigen::Quaterniond::Identity(), {100.0, 0.0, 0.0}}, 0.0);

TEST(Simulator, IsTheRendererWithEverythingInPlace) {
  const Device device = Device::best();
  Simulator simulator(device, one_particle());
  const Image image = simulator.render(kCamera, kShot);

  Renderer renderer(device, options_of(Quality::kBalanced));
  const Scene scene = one_particle();
  const ParticleBuffers particles(device, scene.camera, Precision::kFloat);
  // The rays are a temporary: the renderer keeps what results() needs.
  Pass pass = renderer.render(particles, SensorRays(device, kCamera, renderer.options()), View{});
  EXPECT_EQ(image.data, picture_of(pass.results(), kCamera).data);
  EXPECT_GT(image.at(8, 6, 0), 0.6F);
}

TEST(Simulator, TellsSensorsApart) {
  Simulator made(Device::best(), one_particle());
  Simulator simulator = std::move(made);
  const Image image = simulator.render(kCamera, kShot);
  Camera wider = kCamera;
  wider.fx = 6.0;
  EXPECT_NE(simulator.render(wider, kShot).data, image.data);
  wider.width = 20;
  EXPECT_EQ(simulator.render(wider, kShot).width, 20);
  EXPECT_EQ(simulator.render(kCamera, kShot).data, image.data);
  for (int i = 0; i < 10; ++i) {  // more than are kept
    wider.fy = 7.0 + i;
    (void)simulator.render(wider, kShot);
  }
  EXPECT_EQ(simulator.render(kCamera, kShot).data, image.data);
  wider.fy = -1.0;
  EXPECT_THROW((void)simulator.render(wider, kShot), Error);
}

TEST(Simulator, PutsPointsIntoTheWorld) {
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

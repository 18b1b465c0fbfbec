#include "host/device/render/outputs/camera_output.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "host/core/base/error.hpp"
#include "host/device/render/outputs/cloud.hpp"
#include "tests/render/scene/wall_and_actor.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

using test::at_origin;
using test::still_camera;
using test::wall_and_actor;

std::size_t pixel(const Camera& camera, int x, int y) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.width) + static_cast<std::size_t>(x);
}

TEST(CameraOutput, DepthIsAlongTheAxisAndDistanceAlongTheRay) {
  SceneOnDevice scene(test::device(), wall_and_actor());
  const Sensor sensor = still_camera();
  const Camera& camera = sensor.camera();
  const std::vector<CameraOutput> outputs{CameraOutput::kDepth, CameraOutput::kActors};
  Shot shot = at_origin(sensor);
  shot.edits = {{"ahead", ActorEdit::Remove{}}};
  const Frame frame = scene.render(sensor, shot, request_for(outputs));
  const auto value = [&](CameraOutput output) { return image_of(frame, output).data; };
  const auto depth = value(CameraOutput::kDepth), mean_depth = value(CameraOutput::kMeanDepth);
  const auto distance = value(CameraOutput::kDistance), opacity = value(CameraOutput::kOpacity);
  const auto mean_distance = value(CameraOutput::kMeanDistance);
  const Image normals = image_of(frame, CameraOutput::kNormals);
  EXPECT_EQ(normals.channels, 3);
  // In the camera's axes: x right, y down, z forward.
  const Eigen::Vector3d normal(std::sin(test::kWallYaw), 0.0, -std::cos(test::kWallYaw));
  std::size_t seen = 0;
  for (int y = 1; y + 1 < camera.height; ++y) {
    for (int x = 1; x + 1 < camera.width; ++x) {
      const std::size_t i = pixel(camera, x, y);
      EXPECT_EQ(opacity[i], 1.0F - frame.results().transmittance[i]);
      if (opacity[i] < 0.6F) continue;
      ++seen;
      const Eigen::Vector3d ray((x + 0.5 - camera.cx) / camera.fx, (y + 0.5 - camera.cy) / camera.fy, 1.0);
      const double z = normal.z() * 10.0 / normal.dot(ray);
      EXPECT_NEAR(depth[i], z, 2e-3 * z) << x << ' ' << y;
      EXPECT_NEAR(distance[i], z * ray.norm(), 2e-3 * z * ray.norm()) << x << ' ' << y;
      EXPECT_NEAR(mean_depth[i], depth[i], 1e-3);
      EXPECT_NEAR(mean_distance[i], distance[i], 1e-3);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(normals.at(x, y, c), normal[c], 0.02) << x << ' ' << y;
    }
  }
  EXPECT_GT(seen, 500U);
}

TEST(CameraOutput, NothingIsThereWhereNothingWasMet) {
  Scene empty = wall_and_actor();
  empty.camera.mean().col(0).array() -= 500.0F;  // all behind
  SceneOnDevice scene(test::device(), std::move(empty));
  const Sensor sensor = still_camera();
  Shot shot = at_origin(sensor);
  shot.edits = {{"ahead", ActorEdit::Remove{}}};
  const Frame frame = scene.render(sensor, shot, request_for({CameraOutput::kDepth, CameraOutput::kActors}));
  for (std::size_t output = 1; output < camera_output_names().size(); ++output) {
    const auto one = static_cast<CameraOutput>(output);
    if (one == CameraOutput::kSupport || one == CameraOutput::kFlow || one == CameraOutput::kSceneFlow)
      continue;  // takes more than the frame
    const Image image = image_of(frame, static_cast<CameraOutput>(output));
    EXPECT_TRUE(std::all_of(image.data.begin(), image.data.end(), [](float v) { return v == 0.0F; }))
        << camera_output_names()[output];
  }
}

TEST(CameraOutput, OfALidarActorsAreAColumn) {
  SceneOnDevice scene(test::device(), wall_and_actor());
  const Sensor lidar = test::still_lidar();
  const Frame frame = scene.render(lidar, at_origin(lidar), request_for({CameraOutput::kActors}));
  const PointCloud cloud = point_cloud(frame, {.frame = PointFrame::kSensor, .actors = true});
  ASSERT_EQ(cloud.columns.back(), "actor");
  EXPECT_EQ(cloud.type(cloud.columns.size() - 1), ColumnType::kUint16);
  std::size_t own = 0;
  for (Eigen::Index row = 0; row < cloud.values.rows(); ++row) {
    const bool is_ahead = std::abs(cloud.values(row, 0) - 5.0) < 0.1;
    EXPECT_EQ(cloud.values(row, cloud.values.cols() - 1), is_ahead ? 2.0 : 0.0);
    own += is_ahead ? 1 : 0;
  }
  EXPECT_GT(own, 3U);
  EXPECT_LT(own, static_cast<std::size_t>(cloud.values.rows()));
}

TEST(CameraOutput, WhatAFrameWasNotAskedForIsRefused) {
  SceneOnDevice scene(test::device(), wall_and_actor());
  const Sensor sensor = still_camera();
  const Frame frame = scene.render(sensor, at_origin(sensor));
  for (const CameraOutput output : {CameraOutput::kDepth,
                                    CameraOutput::kDistance,
                                    CameraOutput::kNormals,
                                    CameraOutput::kActors,
                                    CameraOutput::kSupport}) {
    EXPECT_THROW((void)image_of(frame, output), Error);
  }
  const Sensor lidar = test::still_lidar();
  EXPECT_THROW((void)image_of(scene.render(lidar, at_origin(lidar)), CameraOutput::kDepth), Error);
  EXPECT_EQ(camera_output("normals"), CameraOutput::kNormals);
  EXPECT_THROW((void)camera_output("colour"), Error);
}

}  // namespace
}  // namespace simuli

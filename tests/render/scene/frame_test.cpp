#include "host/device/render/scene/frame.hpp"

#include <gtest/gtest.h>
#include <memory>
#include <numbers>

#include "host/core/base/error.hpp"
#include "host/device/render/scene/frame_state.hpp"
#include "tests/render/scene/two_cars.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

using test::shot_of;

TEST(Frame, KeepsItsResultsWhateverIsRenderedLater) {
  const Device& device = test::device();
  const Sensor sensors[] = {test::camera(), test::lidar()};
  std::vector<RayResults> alone;
  for (int i = 0; i < 8; ++i) {
    SceneOnDevice scene(device, test::two_cars());
    alone.push_back(scene.render(sensors[i % 2], shot_of(sensors[i % 2], 0.03 * i)).results());
  }
  for (const bool fetched : {true, false}) {
    auto scene = std::make_unique<SceneOnDevice>(device, test::two_cars());
    std::vector<Frame> frames;
    for (int i = 0; i < 8; ++i) {
      frames.push_back(scene->render(sensors[i % 2], shot_of(sensors[i % 2], 0.03 * i)));
      if (fetched) frames.back().fetch();
    }
    scene.reset();  // frames outlive their renderer
    for (std::size_t i = 0; i < frames.size(); ++i) {
      frames[i].wait();
      EXPECT_TRUE(frames[i].is_ready());
      EXPECT_EQ(frames[i].results().feature[0], alone[i].feature[0]) << i;
      EXPECT_EQ(frames[i].results().median, alone[i].median) << i;
    }
  }
}

TEST(Frame, LeavesItsBuffersToTheNextOnes) {
  const Device& device = test::device();
  SceneOnDevice scene(device, test::two_cars());
  const Sensor lidar = test::lidar();
  const auto render = [&] { (void)scene.render(lidar, shot_of(lidar, 0.1)).results(); };
  render();
  render();
  const std::uint64_t bytes = device.memory().now;
  for (int i = 0; i < 10; ++i) render();
  EXPECT_EQ(device.memory().now, bytes);
}

TEST(Frame, KnowsWhereRaysAreOnTheDevice) {
  SceneOnDevice scene(test::device(), test::two_cars());
  for (const Sensor& sensor : {test::camera(), test::lidar()}) {
    const Frame frame = scene.render(sensor, shot_of(sensor, 0.1));
    const FrameBuffersOfRays at = FrameAccess::buffers(frame);
    const std::vector<float> outputs = at.outputs.download_float();
    const std::vector<std::int32_t> slot = at.slot_of_ray.download(), ray = at.ray_of_slot.download();
    ASSERT_EQ(slot.size(), sensor.ray_count());
    ASSERT_EQ(ray.size(), at.slots);
    for (std::size_t i = 0; i < slot.size(); ++i) {
      const auto place = static_cast<std::size_t>(slot[i]);
      ASSERT_EQ(ray[place], static_cast<std::int32_t>(i));
      for (std::size_t c = 0; c < 3; ++c) {
        ASSERT_EQ(outputs[c * at.slots + place], frame.results().feature[c][i]);
      }
    }
    EXPECT_EQ(at.picture, nullptr);
  }
}

TEST(Frame, HasPointsInTheWorldToAMillimetre) {
  SceneOnDevice scene(test::device(), test::two_cars());
  const Sensor lidar = test::lidar();
  const Shot shot = shot_of(lidar, 0.1);
  const Frame frame = scene.render(lidar, shot);
  const LidarFrame sweep = frame.lidar();
  const std::vector<Eigen::Vector3d> points = frame.points();
  ASSERT_EQ(points.size(), lidar.ray_count());
  EXPECT_GT(sweep.returns(), 100);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d centre = shot.pose_at(sweep.rays.time_fraction[i]).translation;
    // Floats would have steps of half a metre here.
    ASSERT_NEAR((points[i] - centre).norm(), static_cast<double>(sweep.range[i]), 1e-3) << i;
  }
}

TEST(Frame, IsOfItsKindOfSensor) {
  SceneOnDevice scene(test::device(), test::two_cars());
  const Frame picture = scene.render(test::camera(), shot_of(test::camera(), 0.1));
  EXPECT_EQ(picture.image().width, 48);
  EXPECT_THROW((void)picture.lidar(), Error);
  EXPECT_THROW((void)picture.points(), Error);
  EXPECT_THROW((void)scene.render(test::lidar(), shot_of(test::lidar(), 0.1)).image(), Error);
}

TEST(Frame, PutsPointsIntoTheWorldAndIntoTheSensor) {
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
  Shot shot = Shot::at({Eigen::Quaterniond::Identity(), {100.0, 0.0, 0.0}}, 0.0);
  shot.world_from_sensor_end.translation.y() = 1.0;
  // The sensor's x axis points along the world's y axis.
  const Eigen::Quaterniond left(Eigen::AngleAxisd(std::numbers::pi / 2.0, Eigen::Vector3d::UnitZ()));
  const auto expect_points = [&](PointFrame in, const Eigen::Vector3d& first, const Eigen::Vector3d& second) {
    const auto points = points_of(lidar, frame, shot, in);
    EXPECT_LT((points[0] - first).norm(), 1e-9);
    EXPECT_LT((points[1] - second).norm(), 1e-9);
  };
  expect_points(PointFrame::kWorld, {102.0, 0.0, 0.0}, {103.0, 0.5, -0.5});
  shot.world_from_sensor_start.rotation = shot.world_from_sensor_end.rotation = left;
  expect_points(PointFrame::kWorld, {100.0, 2.0, 0.0}, {100.0, 3.5, -0.5});
  expect_points(PointFrame::kSensor, {2.0, 0.0, 0.0}, {3.0, 0.0, -0.5});
  expect_points(PointFrame::kSensorStart, {2.0, 0.0, 0.0}, {3.5, 0.0, -0.5});
  EXPECT_EQ(point_frame("sensor_start"), PointFrame::kSensorStart);
  EXPECT_THROW((void)point_frame("lidar"), Error);
}

TEST(BestDistance, IsTheMeanOfOneSurfaceAndTheMedianOfSeveral) {
  RayResults seen;
  seen.rays = 5;
  seen.transmittance = {0.0F, 0.0F, 0.6F, 0.2F, 0.2F};
  seen.distance = {10.1F, 14.0F, 4.0F, 8.08F, 8.0F};
  seen.median = {10.0F, 10.0F, 0.0F, 10.0F, 10.1F};
  EXPECT_FLOAT_EQ(best_distance(seen, 0), 10.1F);
  EXPECT_FLOAT_EQ(best_distance(seen, 1), 10.0F);  // the mean is between two surfaces
  EXPECT_FLOAT_EQ(best_distance(seen, 2), 10.0F);  // transmittance of one half
  EXPECT_FLOAT_EQ(best_distance(seen, 3), 10.1F);  // transmittance below one half
  EXPECT_FLOAT_EQ(best_distance(seen, 4), 10.0F);
  seen.median.clear();
  EXPECT_FLOAT_EQ(best_distance(seen, 1), 14.0F);
}

}  // namespace
}  // namespace simuli

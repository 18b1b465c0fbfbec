#include "host/device/render/outputs/cloud.hpp"

#include <gtest/gtest.h>

#include "host/core/base/error.hpp"
#include "tests/render/scene/two_cars.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

TEST(Cloud, HasARowPerReturnWithItsBeamAndTime) {
  SceneOnDevice scene(test::device(), test::two_cars());
  const Sensor lidar = test::lidar();
  const Frame frame = scene.render(lidar, test::shot_of(lidar, 0.1));
  const LidarFrame sweep = frame.lidar();
  const PointCloud world = point_cloud(frame, {.coordinates = ColumnType::kDouble});
  EXPECT_EQ(world.columns,
            (std::vector<std::string>{"x", "y", "z", "intensity", "range", "drop", "ring", "time"}));
  EXPECT_EQ(world.type(0), ColumnType::kDouble);
  EXPECT_EQ(world.type(6), ColumnType::kUint16);
  EXPECT_EQ(world.type(7), ColumnType::kFloat);
  ASSERT_EQ(world.values.rows(), sweep.returns());
  EXPECT_GT(sweep.returns(), 100);
  const PointCloud own = point_cloud(frame, {.frame = PointFrame::kSensor});
  EXPECT_EQ(own.type(0), ColumnType::kFloat);
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < lidar.ray_count(); ++i) {
    if (!sweep.is_return(i)) continue;
    EXPECT_EQ(world.values(row, 4), sweep.range[i]);
    EXPECT_EQ(world.values(row, 6), static_cast<double>(i / lidar.columns()));
    const double time_s = world.values(row, 7);
    EXPECT_NEAR(time_s, sweep.rays.time_fraction[i] * lidar.duration_s(), 1e-9);
    const Eigen::Vector3d in_world = world.values.row(row).head<3>(),
                          in_sensor = own.values.row(row).head<3>();
    // The rig's pose at the point's time maps it to the world.
    const Pose world_from_sensor = test::path().at(0.1 + time_s) * lidar.rig_from_sensor();
    EXPECT_LT((world_from_sensor * in_sensor - in_world).norm(), 1e-5) << i;
    ++row;
  }
}

TEST(Cloud, OfAListOfRaysHasNoRing) {
  SceneOnDevice scene(test::device(), test::two_cars());
  RayList list;
  list.name = "list";
  list.range_max = 60.0;
  for (int i = 0; i < 64; ++i) {
    list.azimuth.push_back(0.1 * i);
    list.elevation.push_back(-0.1);
    list.time_fraction.push_back(i / 64.0);
  }
  const Sensor sensor{LidarModel(list)};
  const PointCloud cloud = point_cloud(scene.render(sensor, test::shot_of(sensor, 0.1)));
  EXPECT_EQ(cloud.columns, (std::vector<std::string>{"x", "y", "z", "intensity", "range", "drop", "time"}));
  EXPECT_GT(cloud.values.rows(), 0);
  const Sensor camera = test::camera();
  EXPECT_THROW((void)point_cloud(scene.render(camera, test::shot_of(camera, 0.1))), Error);
}

TEST(Cloud, CoordinatesAreDoubleWhereFloatsStepByMoreThanAMillimetre) {
  EXPECT_EQ(coordinates_to_a_millimetre(8192.0), ColumnType::kFloat);
  EXPECT_EQ(coordinates_to_a_millimetre(8193.0), ColumnType::kDouble);
}

}  // namespace
}  // namespace simuli

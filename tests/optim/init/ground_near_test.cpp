// Tests a LiDAR's blind spot on a rising road.
#include "optim/init/ground_near.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace simuli {
namespace ground_near_test {

constexpr double kSlope = 0.05, kRig_m = 0.4,
                 kVoxel_m = 0.1;  // the rig's height above ground that rises with x

double height(double x) { return kSlope * x; }

/// Returns points of the ground from 4 m around the origin, and of a wall at y = 6 m.
PointSet around_blind_spot() {
  VoxelGrid grid(kVoxel_m);
  for (double x = -15.05; x < 15.1; x += 0.1) {
    for (double y = -15.05; y < 6.0; y += 0.1) {
      if (std::hypot(x, y) > 4.0) grid.add({x, y, height(x)}, 0.2);
    }
    for (double z = 0.0; z < 3.0; z += 0.1) grid.add({x, 6.05, height(x) + z}, 0.2);
  }
  return grid.averages();
}

GroundMap ground_of(const PointSet& points) {
  GroundMap ground;
  ground.add(points.position);
  ground.finish();
  return ground;
}

/// Returns poses on the ground along x.
std::vector<Pose> path() {
  std::vector<Pose> poses;
  for (double x = -5.0; x <= 5.0; x += 1.0) {
    poses.emplace_back(Eigen::Quaterniond(Eigen::AngleAxisd(-std::atan(kSlope), Eigen::Vector3d::UnitY())),
                       Eigen::Vector3d(x, 0.0, height(x) + kRig_m));
  }
  return poses;
}

TEST(GroundNear, FillsWhatNoLaserReached) {
  const PointSet points = around_blind_spot();
  const PointSet found = ground_near(ground_of(points), path(), points, kVoxel_m);
  std::size_t blind = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Eigen::Vector3f p = found.position.col(static_cast<Eigen::Index>(i));
    EXPECT_NEAR(p.z(), height(p.x()), 0.15) << p.transpose();
    EXPECT_TRUE(p.head<2>().norm() < 4.2F || p.y() > 5.7F) << p.transpose();  // elsewhere there are returns
    blind += p.head<2>().norm() < 4.0F ? 1 : 0;
  }
  // One per 0.2 m square of the disc.
  EXPECT_NEAR(static_cast<double>(blind), 3.14159 * 4.0 * 4.0 / 0.04, 60.0);
}

TEST(GroundNear, KnowsNothingWithoutGroundBelowThePath) {
  const PointSet points = around_blind_spot();
  std::vector<Pose> far = path();
  for (Pose& pose : far) pose.translation.x() += 100.0;
  EXPECT_EQ(ground_near(ground_of(points), far, points, kVoxel_m).size(), 0U);
  EXPECT_EQ(ground_near(ground_of(points), {}, points, kVoxel_m).size(), 0U);
}

}  // namespace ground_near_test
}  // namespace simuli

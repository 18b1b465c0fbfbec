#include "host/core/scene/mounting.hpp"

#include <gtest/gtest.h>

namespace simuli {
namespace {

using Eigen::Vector3d;

void expect_near(const Vector3d& found, const Vector3d& expected) {
  EXPECT_LT((found - expected).norm(), 1e-12) << found.transpose() << " for " << expected.transpose();
}

TEST(Mounting, AxesAreTheRigsAtZero) {
  const Mounting mounting{.position_m = {1.0, 2.0, 3.0}};
  expect_near(mounting.rig_from_lidar() * Vector3d(1.0, 0.0, 0.0), {2.0, 2.0, 3.0});
  expect_near(mounting.rig_from_lidar() * Vector3d(0.0, 0.0, 1.0), {1.0, 2.0, 4.0});
  // A camera along x, upright: its right is the rig's right, its down the rig's down.
  expect_near(mounting.rig_from_camera() * Vector3d(0.0, 0.0, 1.0), {2.0, 2.0, 3.0});
  expect_near(mounting.rig_from_camera() * Vector3d(1.0, 0.0, 0.0), {1.0, 1.0, 3.0});
  expect_near(mounting.rig_from_camera() * Vector3d(0.0, 1.0, 0.0), {1.0, 2.0, 2.0});
}

TEST(Mounting, AnglesTurnAsSaid) {
  const Vector3d ahead(0.0, 0.0, 1.0), right(1.0, 0.0, 0.0);                             // of a camera
  expect_near(Mounting{.yaw_deg = 90.0}.rig_from_camera() * ahead, {0.0, 1.0, 0.0});     // to the left
  expect_near(Mounting{.pitch_deg = 90.0}.rig_from_camera() * ahead, {0.0, 0.0, -1.0});  // down
  expect_near(Mounting{.roll_deg = 90.0}.rig_from_camera() * ahead, {1.0, 0.0, 0.0});
  expect_near(Mounting{.roll_deg = 90.0}.rig_from_camera() * right, {0.0, 0.0, -1.0});  // left side up
  // First roll, then pitch, then yaw, about axes of the rig: points to the left, its right side down.
  const Mounting all{.roll_deg = 90.0, .pitch_deg = 0.0, .yaw_deg = 90.0};
  expect_near(all.rig_from_lidar() * Vector3d::UnitX(), {0.0, 1.0, 0.0});
  expect_near(all.rig_from_lidar() * Vector3d::UnitY(), {0.0, 0.0, 1.0});
  const Mounting down{.pitch_deg = 90.0, .yaw_deg = 90.0};
  expect_near(down.rig_from_lidar() * Vector3d::UnitX(), {0.0, 0.0, -1.0});
  expect_near(down.rig_from_lidar() * Vector3d::UnitZ(), {0.0, 1.0, 0.0});
}

TEST(Mounting, IsToldOfAnyPose) {
  for (const double roll : {-170.0, 0.0, 30.0}) {
    for (const double pitch : {-90.0, -89.0, 0.0, 20.0, 90.0}) {
      for (const double yaw : {-100.0, 0.0, 179.0}) {
        const Mounting mounting{{1.0, 2.0, 3.0}, roll, pitch, yaw};
        const Pose camera = mounting.rig_from_camera(), lidar = mounting.rig_from_lidar();
        const Mounting of_camera = Mounting::of_camera(camera), of_lidar = Mounting::of_lidar(lidar);
        EXPECT_LT(of_camera.rig_from_camera().rotation.angularDistance(camera.rotation), 1e-5);
        EXPECT_LT(of_lidar.rig_from_lidar().rotation.angularDistance(lidar.rotation), 1e-5);
        EXPECT_EQ(of_camera.position_m, mounting.position_m);
        if (std::abs(pitch) == 90.0) continue;
        EXPECT_NEAR(of_lidar.roll_deg, roll, 1e-6);
        EXPECT_NEAR(of_lidar.pitch_deg, pitch, 1e-6);
        EXPECT_NEAR(of_lidar.yaw_deg, yaw, 1e-6);
      }
    }
  }
}

}  // namespace
}  // namespace simuli

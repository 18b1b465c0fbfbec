// Tests a pane beside a road, passed by a LiDAR.
#include "optim/init/dark_still.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "optim/base/frames.hpp"

namespace simuli {
namespace {

constexpr double kVoxel_m = 0.2;
constexpr double kPane_m = 5.0;    // y of the pane
constexpr double kHalf_m = 1.5;    // half length along x
constexpr double kBottom_m = 0.5;  // above the ground
constexpr double kTop_m = 1.3;
constexpr double kLidar_m = 1.9;  // above the ground

GroundMap flat_ground() {
  Eigen::Matrix3Xf points(3, 161 * 161);
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    points.col(i) << static_cast<float>(i % 161) * 0.25F - 20.0F, static_cast<float>(i / 161) * 0.25F - 20.0F,
        0.0F;
  }
  GroundMap ground;
  ground.add(points);
  ground.finish();
  return ground;
}

/// Returns a box around the half of the pane at negative x, during all sweeps.
MovingBox box_around_half() {
  MovingBox box{{0.5 * kHalf_m, 0.5, 1.0}, {}, {}};
  box.scene_from_box_start.translation = {-0.5 * kHalf_m, kPane_m, 1.0};
  box.scene_from_box_end = box.scene_from_box_start;
  return box;
}

struct Situation {
  bool is_dark = true;             // otherwise rays pass through the pane
  bool has_ground_returns = true;  // otherwise all rays drop
  std::vector<BlindArc> blind = {};
  std::vector<MovingBox> boxes = {};
};

PointSet found(const Situation& situation) {
  Lidar lidar;
  lidar.name = "side";
  for (int row = 0; row < 24; ++row) lidar.rows.push_back({0.2 - 0.025 * row});
  lidar.columns = 180;
  lidar.azimuth_first = std::numbers::pi / 6.0;
  lidar.azimuth_span = 2.0 * std::numbers::pi / 3.0;
  lidar.range_min = 0.5;
  lidar.range_max = 100.0;
  lidar.blind = situation.blind;
  const LidarModel model = lidar;
  const GroundMap ground = flat_ground();
  DarkStill dark(ground, kVoxel_m);
  for (const bool drops : {true, false}) {
    for (int i = 0; i < 10; ++i) {
      Pose at;
      at.translation = {-5.0 + i, 0.0, kLidar_m};
      PosedSweep posed{model, {nominal_rays(lidar), {}, {}}, at, at};
      for (std::size_t ray = 0; ray < lidar.ray_count(); ++ray) {
        const Eigen::Vector3d d =
            Lidar::direction(posed.sweep.rays.azimuth[ray], posed.sweep.rays.elevation[ray]);
        const Eigen::Vector3d on_pane = at.translation + kPane_m / d.y() * d;
        const bool meets = std::abs(on_pane.x()) < kHalf_m && on_pane.z() > kBottom_m && on_pane.z() < kTop_m;
        // The sky has no return either.
        const double ground_m = d.z() < 0.0 ? kLidar_m / -d.z() : 0.0;
        const bool returns = situation.has_ground_returns && ground_m < 60.0 && !(meets && situation.is_dark);
        posed.sweep.range.push_back(static_cast<float>(returns ? ground_m : 0.0));
        posed.sweep.intensity.push_back(0.5F);
      }
      drops ? dark.add_dropped(posed, situation.boxes) : dark.add_returned(posed);
    }
  }
  return dark.points();
}

TEST(DarkStill, IsWhereRaysDropThatTheGroundWouldAnswer) {
  const PointSet points = found({});
  ASSERT_GT(points.size(), 20U);
  // Rays past the pane's edge share voxels with rays into it: a few of these continue where no other ray was.
  std::size_t near_pane = 0, on_pane = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f p = points.position.col(static_cast<Eigen::Index>(i));
    EXPECT_GT(p.y(), 0.5 * kPane_m) << "rays that came back have passed there, " << i;
    EXPECT_EQ(points.intensity[i], 0.0F);
    const bool is_near = std::abs(p.x()) < kHalf_m + 2.0 * kVoxel_m && p.y() < kPane_m + 1.0;
    near_pane += is_near ? 1 : 0;
    on_pane += is_near && std::abs(p.y() - kPane_m) < 3.0 * kVoxel_m ? 1 : 0;
  }
  EXPECT_GT(10 * near_pane, 8 * points.size());
  EXPECT_GT(10 * on_pane, 3 * points.size());
}

TEST(DarkStill, IsNoneWhereLightComesThrough) { EXPECT_EQ(found({.is_dark = false}).size(), 0U); }

TEST(DarkStill, BlindRaysSayNothing) {
  Situation blind;
  for (int row = 0; row < 24; ++row) blind.blind.push_back({row, 0.0, 2.0 * std::numbers::pi});
  EXPECT_EQ(found(blind).size(), 0U);
}

TEST(DarkStill, RaysThroughWhatDrivesSayNothing) {
  const auto on_pane = [](const PointSet& points, bool left) {
    std::size_t count = 0;
    for (Eigen::Index i = 0; i < points.position.cols(); ++i) {
      const Eigen::Vector3f p = points.position.col(i);
      if (std::abs(p.y() - kPane_m) > 3.0 * kVoxel_m || std::abs(p.x()) > kHalf_m - kVoxel_m) continue;
      count += (p.x() < -kVoxel_m) == left ? 1 : 0;
    }
    return count;
  };
  const PointSet all = found({}), some = found({.boxes = {box_around_half()}});
  ASSERT_GT(on_pane(all, true), 10U);
  EXPECT_EQ(on_pane(some, true), 0U);
  EXPECT_GT(2 * on_pane(some, false), on_pane(all, false));
}

TEST(DarkStill, TheSkySaysNothing) {
  // All rays drop: rays down count, rays up do not.
  const PointSet points = found({.has_ground_returns = false});
  ASSERT_GT(points.size(), 0U);
  EXPECT_LT(points.position.row(2).maxCoeff(), kLidar_m);
}

TEST(DarkStill, SaysTheSameTwice) {
  const PointSet a = found({}), b = found({});
  ASSERT_EQ(a.size(), b.size());
  EXPECT_TRUE(a.position == b.position);
}

}  // namespace
}  // namespace simuli

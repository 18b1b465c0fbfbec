// Tests a wall beside a road whose foot a LiDAR measures from near and from farther away.
#include "optim/init/walls_upward.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "optim/base/frames.hpp"

namespace simuli {
namespace walls_upward_test {

constexpr double kVoxel_m = 0.1;
constexpr double kWall_m = 6.0;   // y
constexpr double kHalf_m = 5.0;   // half length along x
constexpr double kLidar_m = 1.8;  // above the ground

struct Situation {
  double top_m = 20.0;       // top of the wall
  double behind_m = 0.0;     // y of a higher wall behind it; 0: the sky, without returns
  double back_away_m = 0.0;  // y of the LiDAR's trajectory in every second sweep, on the other side
  bool is_list = false;      // the sweeps have no neighbours
  double up_m = 3.0;
};

/// Returns a LiDAR with beams from 20 degrees below the horizon to 5 above.
Lidar lidar() {
  Lidar out;
  out.name = "side";
  for (int row = 0; row <= 50; ++row) {
    out.rows.push_back({(5.0 - 0.5 * row) * std::numbers::pi / 180.0});
  }
  out.columns = 360;
  out.azimuth_first = std::numbers::pi / 6.0;
  out.azimuth_span = 2.0 * std::numbers::pi / 3.0;
  out.range_min = 0.5;
  out.range_max = 100.0;
  return out;
}

double range_m(const Situation& situation, const Eigen::Vector3d& from, const Eigen::Vector3d& d) {
  const auto meets = [&](double y, double half_m, double top_m) {
    const double range = (y - from.y()) / d.y();
    const Eigen::Vector3d p = from + range * d;
    return d.y() > 0.0 && std::abs(p.x()) < half_m && p.z() > 0.0 && p.z() < top_m ? range : 0.0;
  };
  if (const double range = meets(kWall_m, kHalf_m, situation.top_m); range > 0.0) return range;
  if (situation.behind_m > 0.0) {
    if (const double range = meets(situation.behind_m, 1e3, 1e3); range > 0.0) return range;
  }
  return d.z() < 0.0 ? from.z() / -d.z() : 0.0;
}

PointSet found(const Situation& situation) {
  const LidarModel model = lidar();
  const Lidar& rows = std::get<Lidar>(model);
  VoxelGrid grid(kVoxel_m);
  std::vector<PosedSweep> sweeps;
  for (int i = 0; i < 20; ++i) {
    Pose at;
    at.translation = {-5.0 + 0.5 * i, i % 2 == 0 ? 0.0 : -situation.back_away_m, kLidar_m};
    PosedSweep posed{model, {nominal_rays(rows), {}, {}}, at, at};
    for (std::size_t ray = 0; ray < rows.ray_count(); ++ray) {
      const Eigen::Vector3d d =
          Lidar::direction(posed.sweep.rays.azimuth[ray], posed.sweep.rays.elevation[ray]);
      const double range = range_m(situation, at.translation, d);
      posed.sweep.range.push_back(static_cast<float>(range));
      posed.sweep.intensity.push_back(0.7F);
      if (range > 0.0) grid.add(at.translation + range * d, 0.7);
    }
    sweeps.push_back(std::move(posed));
  }
  WallsUpward walls(grid.averages(), kVoxel_m, situation.up_m);
  for (const PosedSweep& posed : sweeps) {
    if (!situation.is_list) walls.look_through(posed);
  }
  return walls.points();
}

TEST(WallsUpward, GoOnWhereNoRayPassed) {
  const PointSet points = found({});
  // At 6 m the LiDAR reaches a height of 2.3 m.
  ASSERT_GT(points.size(), 500U);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f p = points.position.col(static_cast<Eigen::Index>(i));
    EXPECT_NEAR(p.y(), kWall_m, 0.05);
    EXPECT_LT(std::abs(p.x()), kHalf_m + 0.1);
    EXPECT_GT(p.z(), 2.2F);
    EXPECT_LT(p.z(), 6.2F);
    EXPECT_NEAR(points.intensity[i], 0.7F, 1e-3F);
  }
  EXPECT_LT(found({.up_m = 1.0}).size(), points.size() / 2);
}

TEST(WallsUpward, EndWhereRaysFoundTheSky) {
  // The LiDAR measures the top of the wall: rays above it do not return.
  EXPECT_EQ(found({.top_m = 2.0}).size(), 0U);
  // Only from farther away rays pass above the wall.
  for (const double away_m : {12.0, 70.0}) {  // distances with beams 0.2 and 0.7 m apart
    const PointSet far = found({.top_m = 2.6, .back_away_m = away_m});
    for (std::size_t i = 0; i < far.size(); ++i)
      EXPECT_LT(far.position(2, static_cast<Eigen::Index>(i)), 2.6 + std::max(0.3, 0.01 * away_m));
  }
}

TEST(WallsUpward, EndWhereRaysMetWhatIsBehind) {
  const PointSet points = found({.top_m = 2.0, .behind_m = 9.0});
  ASSERT_GT(points.size(), 0U);  // of the wall behind
  EXPECT_GT(points.position.row(1).minCoeff(), 8.9F);
}

TEST(WallsUpward, AreNoneWhereNoSweepHasAWord) { EXPECT_EQ(found({.is_list = true}).size(), 0U); }

}  // namespace walls_upward_test
}  // namespace simuli

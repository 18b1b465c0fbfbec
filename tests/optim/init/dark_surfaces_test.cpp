// Tests a black lorry in front of a wall, passed by a LiDAR.
#include "optim/init/dark_surfaces.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "optim/base/frames.hpp"

namespace simuli {
namespace dark_surfaces_test {

constexpr double kVoxel_m = 0.2;
constexpr double kWall_m = 12.0;  // y of the wall, in the scene
constexpr double kLorry_m = 6.0;  // y of the lorry's centre
const Eigen::Vector3d kBox{6.0, 2.0, 3.0};
const Eigen::Vector3d kBody{4.0, 2.0, 3.0};  // the actual body: the box is longer

Lidar sideways() {
  Lidar lidar;
  lidar.name = "side";
  for (int row = 0; row < 24; ++row) lidar.rows.push_back({0.3 - 0.025 * row});
  lidar.columns = 180;
  lidar.azimuth_first = std::numbers::pi / 6.0;
  lidar.azimuth_span = 2.0 * std::numbers::pi / 3.0;
  lidar.range_min = 0.5;
  lidar.range_max = 100.0;
  return lidar;
}

Actor lorry() {
  Actor actor;
  actor.name = "lorry";
  actor.size_m = kBox;
  for (int i = 0; i < 2; ++i) {
    Pose pose;
    pose.translation = {2.0 * i, kLorry_m, 0.0};  // 2 m/s
    KeyPose key;
    key.time_s = 1.0 * i;
    key.world_from_actor = pose;
    actor.track.push_back(key);
  }
  return actor;
}

bool meets(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, const Eigen::Vector3d& size) {
  double first = 0.0, last = 1e9;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const double a = (-0.5 * size[k] - origin[k]) / direction[k];
    const double b = (0.5 * size[k] - origin[k]) / direction[k];
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  return first < last;
}

/// Returns points of ten sweeps from x = -5 m to 4 m; rays to the body drop, or with `glass` return from the
/// wall.
PointSet found(bool glass, const std::vector<BlindArc>& blind = {}) {
  Lidar lidar = sideways();
  lidar.blind = blind;
  const LidarModel model = lidar;
  const Actor actor = lorry();
  DarkSurfaces dark({actor}, kVoxel_m, Eigen::Vector3d::Zero());
  for (int i = 0; i < 10; ++i) {
    Pose at;
    at.translation = {-5.0 + i, 0.0, 0.0};
    PosedSweep posed{model, {nominal_rays(lidar), {}, {}}, at, at};
    const double time_s = 0.1 * i;
    for (std::size_t ray = 0; ray < lidar.ray_count(); ++ray) {
      const Eigen::Vector3d d =
          Lidar::direction(posed.sweep.rays.azimuth[ray], posed.sweep.rays.elevation[ray]);
      const Pose actor_from_scene = actor.at(time_s).inverse();
      const bool body = meets(actor_from_scene * at.translation, actor_from_scene.rotation * d, kBody);
      const double range = body && !glass ? 0.0 : kWall_m / d.y();
      posed.sweep.range.push_back(static_cast<float>(range < 100.0 ? range : 0.0));
      posed.sweep.intensity.push_back(0.5F);
    }
    dark.add(posed, time_s, time_s);
  }
  return dark.points()[0];
}

TEST(DarkSurfaces, AreWhereRaysDropAndNoneComesThrough) {
  const PointSet points = found(false);
  ASSERT_GT(points.size(), 100U);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f p = points.position.col(static_cast<Eigen::Index>(i));
    // Only the visible side and the ends: not the free metre in front of and behind the body, which returned
    // rays have passed.
    EXPECT_LT(std::abs(p.x()), 0.5 * kBody.x() + 2.0 * kVoxel_m) << i;
    if (std::abs(p.x()) < 1.0F) {
      EXPECT_LT(p.y(), 0.0F) << "no ray gets to the far side, " << i;
    }
    EXPECT_EQ(points.intensity[i], 0.0F);
  }
  const Eigen::VectorXf nearest = points.position.row(1);
  EXPECT_NEAR(nearest.minCoeff(), -0.5 * kBody.y(), kVoxel_m);
}

TEST(DarkSurfaces, AreNoneWhereLightComesThrough) { EXPECT_EQ(found(true).size(), 0U); }

TEST(DarkSurfaces, BlindRaysSayNothing) {
  std::vector<BlindArc> all;
  for (int row = 0; row < 24; ++row) all.push_back({row, 0.0, 2.0 * std::numbers::pi});
  EXPECT_EQ(found(false, all).size(), 0U);
}

TEST(DarkSurfaces, ALabelThatIsNotThereSaysNothing) {
  DarkSurfaces dark({lorry()}, kVoxel_m, Eigen::Vector3d::Zero());
  const LidarModel model = sideways();
  const std::size_t rays = sideways().ray_count();
  const PosedSweep posed{model,
                         {nominal_rays(sideways()), std::vector<float>(rays, 0.0F), std::vector<float>(rays)},
                         Pose{},
                         Pose{}};
  dark.add(posed, 5.0, 5.1);
  EXPECT_EQ(dark.points()[0].size(), 0U);
  for (int i = 0; i < 4; ++i) dark.add(posed, 0.5, 0.6);
  EXPECT_GT(dark.points()[0].size(), 0U);
}

}  // namespace dark_surfaces_test
}  // namespace simuli

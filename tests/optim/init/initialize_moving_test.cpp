#include "optim/init/initialize_moving.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "host/core/base/error.hpp"
#include "optim/init/initialize_views.hpp"
#include "tests/optim/init/points/point_set.hpp"

namespace simuli {
namespace initialize_moving_test {

using test::point_set;

constexpr double kWall_m = 20.0;
constexpr double kRoad_m = -1.7;

Lidar lidar() {
  Lidar lidar = builtin_lidar("generic64");
  lidar.columns = 900;
  return lidar;
}

/// Returns a sweep of a road inside a round wall; with `pole` also of a pole of 0.2 m at (10, 0).
Sweep sweep(bool pole = false) {
  Sweep sweep{nominal_rays(lidar()), {}, {}};
  for (std::size_t i = 0; i < sweep.rays.azimuth.size(); ++i) {
    const Eigen::Vector3d d = Lidar::direction(sweep.rays.azimuth[i], sweep.rays.elevation[i]);
    const double across = std::hypot(d.x(), d.y());
    double range_m = kWall_m / across;
    if (d.z() < 0.0) range_m = std::min(range_m, kRoad_m / d.z());
    if (pole && d.x() > 0.0 && std::abs(10.0 * d.y() / d.x()) < 0.1)
      range_m = std::min(range_m, 10.0 / d.x());
    sweep.range.push_back(static_cast<float>(range_m));
    sweep.intensity.push_back(0.5F);
  }
  return sweep;
}

std::vector<PointVotes> votes_of(const Sweep& s,
                                 const std::vector<Eigen::Vector3f>& positions,
                                 int sweeps = 1) {
  const PointSet points = point_set(positions);
  std::vector<PointVotes> votes(points.size());
  for (int i = 0; i < sweeps; ++i) vote_on_points(s, lidar(), Pose{}, Pose{}, points, votes);
  return votes;
}

TEST(Moving, APointBeforeTheWallIsLookedThroughOnAllSides) {
  std::vector<Eigen::Vector3f> ghosts;
  for (int i = 0; i < 36; ++i) {  // also across the seam of the sweep
    const float azimuth = 0.1745F * static_cast<float>(i);
    ghosts.emplace_back(10.0F * std::cos(azimuth), 10.0F * std::sin(azimuth), -0.5F);
  }
  for (const PointVotes& votes : votes_of(sweep(), ghosts, 3)) {
    EXPECT_EQ(votes.through, 3);
    EXPECT_EQ(votes.there, 0);
    EXPECT_TRUE(is_moving(votes));
  }
}

TEST(Moving, WallRoadAndPoleAreThere) {
  std::vector<Eigen::Vector3f> fixed;
  for (int i = 0; i < 36; ++i) {
    const float azimuth = 0.1745F * static_cast<float>(i);
    for (const float rho : {5.0F, 8.0F, 12.0F, 16.0F, 19.5F}) {  // increasingly grazing
      fixed.emplace_back(rho * std::cos(azimuth), rho * std::sin(azimuth), static_cast<float>(kRoad_m));
    }
    fixed.emplace_back(20.0F * std::cos(azimuth), 20.0F * std::sin(azimuth), -1.0F);
  }
  for (const PointVotes& votes : votes_of(sweep(), fixed, 3)) {
    EXPECT_EQ(votes.through, 0);
    EXPECT_EQ(votes.there, 3);
  }
  const std::vector<Eigen::Vector3f> on_pole{{10.0F, 0.0F, -0.5F}};
  EXPECT_EQ(votes_of(sweep(true), on_pole)[0].there, 1);
  EXPECT_EQ(votes_of(sweep(false), on_pole)[0].through, 1);
}

TEST(Moving, FarPointsAreToldWhereRowsAreNearEachOther) {
  const auto through = [](float rho_m, double share_of_elevations) {
    Lidar sensor = lidar();
    for (LidarRow& row : sensor.rows) row.elevation *= share_of_elevations;
    Sweep far{nominal_rays(sensor), {}, {}};
    far.range.assign(sensor.ray_count(), 90.0F);
    far.intensity.assign(sensor.ray_count(), 0.5F);
    std::vector<PointVotes> votes(1);
    vote_on_points(far, sensor, Pose{}, Pose{}, point_set({{rho_m, 0.0F, -0.5F}}), votes);
    return votes[0].through;
  };
  EXPECT_EQ(through(38.0F, 1.0), 1);
  EXPECT_EQ(through(50.0F, 1.0), 0);
  EXPECT_EQ(through(50.0F, 0.3), 1);
  EXPECT_EQ(through(68.0F, 0.3), 1);
  EXPECT_EQ(through(72.0F, 0.3), 0);
}

TEST(Moving, WhatCannotBeToldGetsNoVote) {
  Sweep nothing_back = sweep();
  std::fill(nothing_back.range.begin(), nothing_back.range.end(), 0.0F);
  const std::vector<Eigen::Vector3f> ghost{{10.0F, 0.0F, -0.5F}};
  EXPECT_EQ(votes_of(nothing_back, ghost)[0].through, 0);
  for (const PointVotes& votes : votes_of(sweep(),
                                          {{30.0F, 0.0F, -1.0F},     // behind the wall
                                           {10.0F, 0.0F, 5.0F},      // above all beams
                                           {2.0F, 0.0F, -1.7F},      // below all beams
                                           {45.0F, 0.0F, -1.0F},     // too far
                                           {0.5F, 0.0F, -0.1F}})) {  // on the ego vehicle
    EXPECT_EQ(votes.through, 0);
    EXPECT_EQ(votes.there, 0);
  }
}

TEST(Moving, TheSensorsOwnMotionIsUndone) {
  // The sensor moves 6 m in the sweep; the pole is measured straight ahead at half time.
  const Pose start{Eigen::Quaterniond::Identity(), {-3.0, 0.0, 0.0}};
  const Pose end{Eigen::Quaterniond::Identity(), {3.0, 0.0, 0.0}};
  const PointSet points = point_set({{10.0F, 0.0F, -0.5F}});
  std::vector<PointVotes> votes(1);
  vote_on_points(sweep(true), lidar(), start, end, points, votes);
  EXPECT_EQ(votes[0].there, 1);
  std::vector<PointVotes> standing(1);  // from the first pose, the pole is 13 m away
  vote_on_points(sweep(true), lidar(), start, start, points, standing);
  EXPECT_EQ(standing[0].there, 0);
}

TEST(Moving, BlocksChangeNoVote) {
  std::vector<Eigen::Vector3f> places;
  for (int i = 0; i < 3000; ++i) {  // a spiral up to 60 m, only 40 m of which are judged
    const float azimuth = 0.37F * static_cast<float>(i), away_m = 0.02F * static_cast<float>(i);
    places.emplace_back(away_m * std::cos(azimuth), away_m * std::sin(azimuth), -0.5F);
  }
  const PointSet points = point_set(places);
  const PointBlocks blocks(points);
  const Pose start{Eigen::Quaterniond::Identity(), {-3.0, 0.0, 0.0}};
  const Pose end{Eigen::Quaterniond::Identity(), {3.0, 0.0, 0.0}};
  std::vector<PointVotes> all(points.size()), some(points.size());
  vote_on_points(sweep(true), lidar(), start, end, points, all);
  vote_on_points(sweep(true), lidar(), start, end, points, some, &blocks);
  std::size_t voted = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].through, some[i].through) << i;
    EXPECT_EQ(all[i].there, some[i].there) << i;
    voted += all[i].through + all[i].there > 0 ? 1U : 0U;
  }
  EXPECT_GT(voted, 500U);
}

TEST(Moving, NeedsThreeSweepsAndTheMajority) {
  EXPECT_FALSE(is_moving({2, 0}));
  EXPECT_TRUE(is_moving({3, 2}));
  EXPECT_FALSE(is_moving({3, 3}));
  EXPECT_FALSE(is_moving({0, 0}));
}

TEST(Moving, SizesThatDoNotFitAreRefused) {
  std::vector<PointVotes> votes(2);
  EXPECT_THROW(vote_on_points(sweep(), lidar(), Pose{}, Pose{}, point_set({{1, 1, 1}}), votes), Error);
}

}  // namespace initialize_moving_test
}  // namespace simuli

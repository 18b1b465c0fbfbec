#include "optim/actors/find_actors.hpp"

#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <stdlib.h>

#include "host/core/base/angles.hpp"
#include "optim/actors/compare_actors.hpp"
#include "tests/host/expect_error.hpp"
#include "tests/optim/actors/moving_world.hpp"

namespace simuli {
namespace {

using Eigen::Vector3d;
using test::Motion2d;
using test::MovingWorld;

constexpr FrameSelection kAllFrames{.held_out_every = 0}, kEveryFifth{.held_out_every = 5};
const Vector3d kCar_m(4.2, 2.0, 1.5);  // including mirrors

Pose on_road(double x, double y, double heading) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(heading, Vector3d::UnitZ())), {x, y, 0.0}};
}

class FindActors : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::temp_directory_path() / "simuli_actors_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] Log write(const MovingWorld& world) const { return write_world(world, folder_ / "log"); }
  /// Returns the match of the only found actor with the label.
  static ActorMatch only_match(const Actor& label, const std::vector<Actor>& found) {
    EXPECT_EQ(found.size(), 1U);
    const ActorComparison comparison = compare_actors({label}, found, 1.0);
    EXPECT_EQ(comparison.others.size(), 0U);
    EXPECT_EQ(comparison.labels.size(), 1U);
    return comparison.labels.empty() ? ActorMatch{} : comparison.labels[0];
  }

  std::filesystem::path folder_;
};

/// Oncoming, on a curve with a radius of 60 m.
Pose curve(double time_s) {
  const double angle = 7.0 * time_s / 60.0;
  return on_road(
      26.0 - 60.0 * std::sin(angle), 3.0 - 60.0 * (1.0 - std::cos(angle)) * 0.2, M_PI + 0.2 * angle);
}

TEST_F(FindActors, ACarOnACurvePastWalls) {
  MovingWorld world;
  world.boxes = test::car(curve);
  const Log log = write(world);
  const FoundActors found = find_actors(log, kAllFrames, {});
  const ActorMatch match = only_match(test::label_of(kCar_m, curve, 2.4), found.actors);
  EXPECT_GE(match.times, 20U);
  EXPECT_LT(match.centre_m, 0.1);
  EXPECT_LT(match.heading_rad, 2.0 * kDegree);
  EXPECT_NEAR(match.found_size_m.x(), 4.2, 0.5);
  EXPECT_NEAR(match.found_size_m.z(), 1.5, 0.25);
  EXPECT_EQ(found.report.actors, 1U);
  EXPECT_GT(found.report.moving_on_actors, found.report.moving_returns / 2);
  const FoundActors again = find_actors(log, kAllFrames, {});
  ASSERT_EQ(again.actors.size(), 1U);
  ASSERT_EQ(again.actors[0].track.size(), found.actors[0].track.size());
  for (std::size_t k = 0; k < again.actors[0].track.size(); ++k) {
    EXPECT_EQ(again.actors[0].track[k].world_from_actor.translation,
              found.actors[0].track[k].world_from_actor.translation);
  }
}

TEST_F(FindActors, HeldOutSweepsAreNotReadAndTracksReachOverThem) {
  MovingWorld world;
  world.boxes = test::car(curve);
  const Log log = write(world);
  const HeldOutRule rule(log, kEveryFifth);
  for (std::size_t i = 0; i < log.sweeps.size(); ++i) {
    if (rule.use(i, log.sweeps[i]) != FrameUse::kTraining)
      std::ofstream(log.folder / log.sweeps[i].file) << "not a picture";
  }
  const FoundActors found = find_actors(log, kEveryFifth, {});
  const ActorMatch match = only_match(test::label_of(kCar_m, curve, 2.4), found.actors);
  EXPECT_LT(match.centre_m, 0.1);
  for (std::size_t i = 0; i + 1 < log.sweeps.size(); ++i) {
    if (rule.use(i, log.sweeps[i]) == FrameUse::kTraining) continue;
    EXPECT_TRUE(found.actors[0].is_there(0.5 * (log.sweeps[i].time_start_s + log.sweeps[i].time_end_s))) << i;
  }
}

TEST_F(FindActors, OneThatStopsIsOneActorForItsWholeLife) {
  const Motion2d stopping = [](double time_s) {  // 6 m/s, decelerating by 5 m/s^2 from 0.6 s
    const double braked_s = std::min(std::max(time_s - 0.6, 0.0), 1.2);
    return on_road(10.0 + 6.0 * std::min(time_s, 0.6) + 6.0 * braked_s - 2.5 * braked_s * braked_s, 0.3, 0.0);
  };
  MovingWorld world;
  world.sweeps = 36;
  world.speed_m_per_s = 2.0;
  world.boxes = test::car(stopping);
  const ActorMatch match =
      only_match(test::label_of(kCar_m, stopping, 3.6), find_actors(write(world), kAllFrames, {}).actors);
  EXPECT_GE(match.times, 34U);
  EXPECT_LT(match.centre_m, 0.1);
  EXPECT_LT(match.heading_rad, 2.0 * kDegree);
}

TEST_F(FindActors, ALongOneIsNotCut) {
  const Motion2d ahead = [](double time_s) { return on_road(15.0 + 6.0 * time_s, -3.2, 0.0); };
  const Vector3d size_m(12.0, 2.5, 2.9);
  MovingWorld world;
  world.speed_m_per_s = 2.0;
  world.boxes = {{size_m, ahead, true}};
  const ActorMatch match =
      only_match(test::label_of(size_m, ahead, 2.4), find_actors(write(world), kAllFrames, {}).actors);
  EXPECT_NEAR(match.found_size_m.x(), 11.2, 1.0);  // its far end is measured at 6 degrees by few rays
  EXPECT_LT(match.centre_m, 0.1);
  EXPECT_LT(match.heading_rad, 2.0 * kDegree);
}

TEST_F(FindActors, ALabelThatDrivesThroughWhatStandsIsTold) {
  MovingWorld world;
  world.boxes = test::car(curve);
  Log log = write(world);
  const auto add = [&](const std::string& name, const Vector3d& size_m, double x, double y) {
    log.actors.push_back(test::label_of(
        size_m, [&](double time_s) { return on_road(x + world.speed_m_per_s * time_s, y, 0.0); }, 2.4));
    log.actors.back().name = name;
  };
  add("wide", {60.0, 20.0, 4.0}, 30.0, 12.0);
  add("parked", {20.0, 3.0, 3.0}, 15.0, -5.0);
  add("nothing", {4.0, 2.0, 1.5}, 8.0, 0.0);
  log.actors.push_back(test::label_of(kCar_m, curve, 2.4));
  const FoundActors found = find_actors(log, kAllFrames, {});
  EXPECT_EQ(found.standing, (std::vector<std::string>{"wide", "parked"}));
  EXPECT_EQ(found.actors.size(), 1U);
}

TEST_F(FindActors, WhatStandsIsNeverFound) {
  const FoundActors found = find_actors(write({.boxes = {}, .speed_m_per_s = 9.0}), kAllFrames, {});
  EXPECT_TRUE(found.actors.empty());
  EXPECT_EQ(found.report.sweeps, 24U);
  EXPECT_EQ(found.report.actors, 0U);
}

TEST_F(FindActors, AWalkerIsAtMostOneSmallActor) {
  // Crosses the road; legs and arms swing.
  const auto walker = [](double time_s) { return on_road(14.0, -5.0 + 2.2 * time_s, 0.5 * M_PI); };
  const auto limb = [&](const Vector3d& size, const Vector3d& base, double swing_m) {
    return test::WorldBox{size,
                          [=](double time_s) {
                            const Vector3d at = base + Vector3d(swing_m * std::sin(12.0 * time_s), 0.0, 0.0);
                            return walker(time_s) * Pose{Eigen::Quaterniond::Identity(), at};
                          },
                          true};
  };
  MovingWorld world;
  world.sweeps = 36;
  world.speed_m_per_s = 1.0;
  world.boxes = {limb({0.3, 0.45, 0.8}, {0.0, 0.0, 0.9}, 0.0),
                 limb({0.2, 0.15, 0.9}, {0.0, 0.12, 0.0}, 0.3),
                 limb({0.2, 0.15, 0.9}, {0.0, -0.12, 0.0}, -0.3)};
  const FoundActors found = find_actors(write(world), kAllFrames, {});
  EXPECT_LE(found.actors.size(), 1U);
  EXPECT_GT(found.report.moving_returns, 200U);
  for (const Actor& actor : found.actors) {
    EXPECT_LT(actor.size_m.head<2>().maxCoeff(), 1.6);
    for (const KeyPose& key : actor.track)
      EXPECT_LT((key.world_from_actor.translation - walker(key.time_s).translation).head<2>().norm(), 0.5);
  }
}

TEST_F(FindActors, OptionsOutsideTheirRangeAreRefused) {
  expect_error(ErrorKind::kUsage, "actors.min_sweeps: found 1", [] {
    (void)find_actors(Log{}, kAllFrames, {.min_sweeps = 1});
  });
}

}  // namespace
}  // namespace simuli

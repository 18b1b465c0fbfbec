#include "host/scene/actor.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "tests/host/expect_error.hpp"

namespace simuli {
namespace {

using Eigen::Vector3d;

constexpr double kExact = 1e-12;

Eigen::Quaterniond yaw(double angle) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vector3d::UnitZ()));
}

Actor car() {
  Actor actor;
  actor.name = "car_1";
  actor.kind = "car";
  actor.size_m = {4.0, 1.8, 1.5};
  actor.track = {{1.0, {yaw(0.0), {10, 0, 0}}}, {1.1, {yaw(0.2), {11, 0, 0}}}, {1.3, {yaw(0.2), {14, 1, 0}}}};
  return actor;
}

TEST(Actor, IsBetweenItsKeyPoses) {
  const Actor actor = car();
  EXPECT_TRUE(actor.at(1.05).translation.isApprox(Vector3d(10.5, 0, 0), kExact));
  EXPECT_LT(actor.at(1.05).rotation.angularDistance(yaw(0.1)), kExact * 1e4);
  EXPECT_TRUE(actor.at(1.2).translation.isApprox(Vector3d(12.5, 0.5, 0), kExact));
  // Outside, the end segments go on.
  EXPECT_TRUE(actor.at(1.4).translation.isApprox(Vector3d(15.5, 1.5, 0), kExact));
  EXPECT_TRUE(actor.at(0.95).translation.isApprox(Vector3d(9.5, 0, 0), kExact));
}

TEST(Actor, IsThereAsLongAsItsTrackTells) {
  const Actor actor = car();
  EXPECT_TRUE(actor.is_there(1.0 - 0.9 * Actor::kReach_s));
  EXPECT_FALSE(actor.is_there(1.0 - 1.1 * Actor::kReach_s));
  EXPECT_TRUE(actor.is_there(1.3 + 0.9 * Actor::kReach_s));
  EXPECT_FALSE(actor.is_there(1.3 + 1.1 * Actor::kReach_s));
  EXPECT_FALSE(Actor{}.is_there(0.0));
}

TEST(Actor, OfOneKeyPoseStandsStill) {
  Actor actor = car();
  actor.track.resize(1);
  EXPECT_TRUE(actor.at(1.07).translation.isApprox(Vector3d(10, 0, 0), kExact));
  EXPECT_EQ(actor.key_share(1.07).share, 0.0);
}

TEST(Actor, MovesWithItsLearnedOffsets) {
  Actor actor = car();
  actor.track[0].shift_m = {0.0, 0.4, 0.0};
  actor.track[1].turn_rad = {0.0, 0.0, 0.1};
  const Pose middle = actor.at(1.05);
  EXPECT_TRUE(middle.translation.isApprox(Vector3d(10.5, 0.2, 0), kExact));
  EXPECT_LT(middle.rotation.angularDistance(yaw(0.15)), 1e-7);
}

TEST(Actor, TellsWhatAPoseIsMadeOf) {
  const Actor actor = car();
  const double h = 1e-6;
  for (const double time_s : {0.97, 1.0, 1.03, 1.1, 1.25, 1.35}) {
    const KeyShare share = actor.key_share(time_s);
    for (std::size_t key = 0; key < actor.track.size(); ++key) {
      Actor moved = actor;
      moved.track[key].shift_m.x() = h;
      const double slope = (moved.at(time_s).translation - actor.at(time_s).translation).x() / h;
      const double expected = key == share.key ? 1.0 - share.share : key == share.key + 1 ? share.share : 0.0;
      EXPECT_NEAR(slope, expected, 1e-6) << time_s << " s, key " << key;
    }
  }
}

TEST(Actor, ViewsAreRelativeToTheSceneOrigin) {
  const std::vector<Actor> actors{car(), [] {
                                    Actor late = car();
                                    for (KeyPose& key : late.track) key.time_s += 10.0;
                                    return late;
                                  }()};
  const auto views = actors_during(actors, 1.0, 1.1, {10, 20, 30});
  ASSERT_EQ(views.size(), 2U);
  EXPECT_TRUE(views[0].is_there);
  EXPECT_FALSE(views[1].is_there);
  EXPECT_TRUE(views[0].scene_from_actor_start.translation.isApprox(Vector3d(0, -20, -30), kExact));
  EXPECT_TRUE(views[0].scene_from_actor_end.translation.isApprox(Vector3d(1, -20, -30), kExact));
}

TEST(Actor, TravelsFromItsFirstPose) { EXPECT_NEAR(car().travel_m(), std::hypot(4.0, 1.0), kExact); }

TEST(Actor, RefusesWhatNoActorIs) {
  const auto expect_refused = [](const Actor& actor, const char* part) {
    expect_error(ErrorKind::kInput, part, [&] { validate(actor, "log.json"); });
  };
  EXPECT_NO_THROW(validate(car(), "log.json"));
  Actor actor = car();
  actor.name.clear();
  expect_refused(actor, "name");
  actor = car();
  actor.size_m.y() = 0.0;
  expect_refused(actor, "size");
  actor = car();
  actor.track.clear();
  expect_refused(actor, "track");
  actor = car();
  actor.track[2].time_s = 1.1;
  expect_refused(actor, "track[2]");
  actor = car();
  actor.track[1].world_from_actor.translation.z() = std::numeric_limits<double>::quiet_NaN();
  expect_refused(actor, "track[1]");
  expect_error(ErrorKind::kUsage, "found \"bus\", allowed car_1", [] { (void)find_actor({car()}, "bus"); });
}

}  // namespace
}  // namespace simuli

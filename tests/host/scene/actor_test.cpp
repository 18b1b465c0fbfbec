#include "host/core/scene/actor.hpp"

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
  // Outside, the end segments are extrapolated.
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

Deformation swinging() {
  Deformation shape;
  shape.nodes = {2, 3, 2};
  shape.start_s = 2.0;
  shape.interval_s = 0.5;
  shape.offsets_m.resize(5 * 3 * shape.node_count());
  for (std::size_t i = 0; i < shape.offsets_m.size(); ++i)
    shape.offsets_m[i] = 0.3 * std::sin(1.7 * static_cast<double>(i));
  return shape;
}

TEST(Deformation, IsAMeanOfKnotsAtAllTimes) {
  const Deformation shape = swinging();
  ASSERT_EQ(shape.knots(), 5U);
  for (double time_s = -3.0; time_s < 9.0; time_s += 0.037) {
    const Deformation::KnotShares at = shape.shares(time_s);
    double sum = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_LT(at.knot[k], 5U);
      EXPECT_GE(at.share[k], 0.0);
      sum += at.share[k];
    }
    EXPECT_NEAR(sum, 1.0, kExact);
  }
  // At a knot: a sixth of each neighbour, two thirds of its own.
  const std::vector<double> at = shape.at(3.0);
  const std::size_t row = 3 * shape.node_count();
  for (std::size_t i = 0; i < row; ++i) {
    const double* const o = shape.offsets_m.data() + i;
    EXPECT_NEAR(at[i], (o[row] + 4.0 * o[2 * row] + o[3 * row]) / 6.0, kExact);
  }
}

TEST(Deformation, GoesBackTheWayItCame) {
  const Deformation shape = swinging();  // from 2 s to 4 s
  for (const double beyond_s : {0.1, 0.7, 1.9}) {
    const auto expect_same = [&](double one_s, double other_s) {
      const std::vector<double> a = shape.at(one_s), b = shape.at(other_s);
      for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], kExact);
    };
    expect_same(4.0 + beyond_s, 4.0 - beyond_s);
    expect_same(2.0 - beyond_s, 2.0 + beyond_s);
  }
  // Without a jump.
  for (double time_s = 1.0; time_s < 7.0; time_s += 0.001) {
    const std::vector<double> a = shape.at(time_s), b = shape.at(time_s + 0.001);
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 0.005);
  }
}

TEST(Deformation, IsLinearBetweenItsNodes) {
  // Offsets that are linear in position are interpolated exactly in the box and constant outside.
  const std::array<int, 3> nodes{3, 4, 6};
  const Vector3d half(0.5, 0.3, 0.9);
  const auto linear = [](const Vector3d& p) {
    return Vector3d(0.1 + p.x() - 2.0 * p.z(), 0.3 * p.y(), p.x() + p.y() + p.z());
  };
  std::vector<double> offsets;
  for (int z = 0; z < 6; ++z) {
    for (int y = 0; y < 4; ++y) {
      for (int x = 0; x < 3; ++x) {
        const Vector3d o =
            linear({half.x() * (x - 1.0), half.y() * (2.0 * y / 3.0 - 1.0), half.z() * (0.4 * z - 1.0)});
        offsets.insert(offsets.end(), o.begin(), o.end());
      }
    }
  }
  for (const Vector3d& p : {Vector3d(0.1, -0.29, 0.5), Vector3d(-0.5, 0.3, -0.9), Vector3d(0, 0, 0)}) {
    EXPECT_LT((deformation_at(nodes, half, offsets, p) - linear(p)).norm(), kExact);
  }
  EXPECT_LT((deformation_at(nodes, half, offsets, {3.0, 0.1, -5.0}) - linear({0.5, 0.1, -0.9})).norm(),
            kExact);
}

TEST(Deformation, IsRefusedWhenItIsNone) {
  const auto refuse = [](const auto& change, const std::string& word) {
    Actor actor = car();
    actor.deformation = swinging();
    change(actor.deformation);
    expect_error(ErrorKind::kInput, word, [&] { validate(actor, "here"); });
  };
  refuse([](Deformation& d) { d.nodes[1] = 1; }, "2 to 32");
  refuse([](Deformation& d) { d.offsets_m.pop_back(); }, "179 numbers");
  refuse([](Deformation& d) { d.interval_s = 0.0; }, "above 0");
  refuse([](Deformation& d) { d.offsets_m[3] = std::numeric_limits<double>::quiet_NaN(); }, "NaN");
}

TEST(Actor, ShowsItsShapeDuringAFrame) {
  Actor actor = car();
  actor.deformation = swinging();
  const auto views = actors_during({actor, car()}, 1.05, 1.15, Vector3d::Zero());
  EXPECT_EQ(views[0].deformation.start_m, actor.deformation.at(1.05));
  EXPECT_EQ(views[0].deformation.end_m, actor.deformation.at(1.15));
  EXPECT_EQ(views[0].deformation.half_m, Vector3d(2.0, 0.9, 0.75));
  EXPECT_TRUE(views[1].deformation.empty());
}

}  // namespace
}  // namespace simuli

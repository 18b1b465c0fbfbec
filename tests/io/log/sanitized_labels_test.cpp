#include "io/log/sanitized_labels.hpp"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>

namespace simuli {
namespace {

using Eigen::Vector3d;
constexpr double kPi = std::numbers::pi;

Pose at(const Vector3d& p_world, double heading_rad) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(heading_rad, Vector3d::UnitZ())), p_world};
}

/// Returns 13 labels at this rate of an object ten metres ahead of the rig, which moves like the rig at 5
/// m/s.
Actor thing(const Vector3d& size_m, double rate_hz = 10.0, double m_per_s = 5.0) {
  Actor actor{.name = "car", .kind = "car", .size_m = size_m, .track = {}};
  for (int i = 0; i < 13; ++i)
    actor.track.push_back({i / rate_hz, at({10.0 + m_per_s * i / rate_hz, 3.0, 0.8}, 0.0)});
  return actor;
}
const Vector3d kCar(4.2, 1.8, 1.5), kPerson(0.6, 0.7, 1.8);

/// Returns a log of a rig with a LiDAR on the roof and a camera, which moves along x.
Log log_with(Actor actor) {
  Log log;
  log.cameras.push_back({{"front", 64, 48, 50.0, 50.0, 32.0, 24.0}, at({0.5, 0.0, 1.4}, 0.0)});
  Lidar lidar;
  lidar.name = "top";
  log.lidars.push_back({lidar, at({0.0, 0.0, 1.75}, 0.0)});
  log.world_from_rig = Trajectory({{0.0, at({0.0, 0.0, 0.0}, 0.0)}, {13.0, at({65.0, 0.0, 0.0}, 0.0)}});
  log.actors.push_back(std::move(actor));
  return log;
}

struct HeadingCase {
  const char* name;
  Vector3d size_m;
  double rate_hz;
  std::vector<double> off_rad;  // errors of the first labels; later labels are correct
  double m_per_s = 5.0;
  const char* said = "";              // part of the message
  std::vector<double> left_rad = {};  // errors after sanitising
};

class SanitizedHeadings : public testing::TestWithParam<HeadingCase> {};

TEST_P(SanitizedHeadings, AreTheThings) {
  const HeadingCase& c = GetParam();
  Actor actor = thing(c.size_m, c.rate_hz, c.m_per_s);
  for (std::size_t i = 0; i < c.off_rad.size(); ++i)
    actor.track[i].world_from_actor.rotation = at(Vector3d::Zero(), c.off_rad[i]).rotation;
  Log log = log_with(actor);
  const std::vector<std::string> said = sanitize_labels(log);
  ASSERT_EQ(log.actors.size(), 1U);
  ASSERT_EQ(said.size(), c.said[0] == '\0' ? 0U : 1U);
  if (!said.empty()) {
    EXPECT_NE(said[0].find(c.said), std::string::npos) << said[0];
  }
  for (std::size_t i = 0; i < actor.track.size(); ++i) {
    const double left_rad = i < c.left_rad.size() ? c.left_rad[i] : 0.0;
    EXPECT_NEAR(at(Vector3d::Zero(), left_rad)
                    .rotation.angularDistance(log.actors[0].track[i].world_from_actor.rotation),
                0.0,
                1e-6)
        << "label " << i;
    EXPECT_EQ(log.actors[0].track[i].world_from_actor.translation,
              actor.track[i].world_from_actor.translation);
  }
}

const std::vector<double> kTurning{0.0, 0.1, 0.25, 0.4, 0.6, 0.7, 0.8, 0.8, 0.7, 0.5, 0.3, 0.2, 0.1};
const std::vector<double> kAboutTurn{0.0, 0.0, 0.0, 0.9, 1.8, 2.7, kPi, kPi, kPi, kPi, kPi, kPi, kPi};
const std::vector<double> kBackwards(13, kPi);

INSTANTIATE_TEST_SUITE_P(
    Tracks,
    SanitizedHeadings,
    testing::Values(
        HeadingCase{
            "TwoInBetween", kCar, 10.0, {0, 0, 0, 0, 0, kPi, kPi}, 5.0, "2 of 13 headings are reversed"},
        HeadingCase{"TheFirst", kCar, 10.0, {kPi}, 5.0, "1 of 13"},
        HeadingCase{
            "EverySecond", kCar, 10.0, {kPi, 0, kPi, 0, kPi, 0, kPi, 0, kPi, 0, kPi, 0, kPi}, 5.0, "7 of 13"},
        HeadingCase{"MostOfADrivingOne", kCar, 10.0, std::vector<double>(10, kPi), 5.0, "10 of 13"},
        HeadingCase{"FewOfAStandingOne", kCar, 10.0, std::vector<double>(5, kPi), 0.0, "5 of 13"},
        HeadingCase{"AtTwoHertz", kCar, 2.0, {0, 0, kPi, kPi}, 5.0, "2 of 13"},
        HeadingCase{"NotQuiteHalfATurn", kCar, 10.0, {0, 0, kPi - 0.3}, 5.0, "1 of 13", {0, 0, -0.3}},
        HeadingCase{"OfAPerson", kPerson, 10.0, {0, 0, 0, kPi}, 1.5, "1 of 13"},
        HeadingCase{"AcrossForOne", kCar, 10.0, {0, 0, 0, kPi / 2.0}, 5.0, "1 of 13 headings are outliers"},
        HeadingCase{"TheFirstAcross", kCar, 10.0, {kPi / 2.0}, 5.0, "1 of 13 headings are outliers"},
        HeadingCase{"AcrossForLong",
                    kCar,
                    10.0,
                    std::vector<double>(6, kPi / 2.0),
                    5.0,
                    "turns by 90 degrees in 0.10 s at 0.60 s, left",
                    std::vector<double>(6, kPi / 2.0)},
        // Correct labels are unchanged.
        HeadingCase{"Right", kCar, 10.0, {}},
        HeadingCase{"Turning", kCar, 5.0, kTurning, 5.0, "", kTurning},
        HeadingCase{"PersonWhoTurnsAround", kPerson, 10.0, kAboutTurn, 0.0, "", kAboutTurn},
        HeadingCase{"PersonAtTwoHertz", kPerson, 2.0, {0, 0, kPi, kPi}, 1.0, "", {0, 0, kPi, kPi}},
        HeadingCase{"DrivingBackwards", kCar, 10.0, kBackwards, 5.0, "", kBackwards}),
    [](const auto& of) { return of.param.name; });

struct OwnCase {
  const char* name;
  Vector3d size_m, p_rig;
  std::size_t at_first;  // labels at p_rig of the rig; the others are far away
  std::size_t left;
  const char* said;
};

class OwnVehicleLabel : public testing::TestWithParam<OwnCase> {};

TEST_P(OwnVehicleLabel, IsLeftOut) {
  const OwnCase& c = GetParam();
  Actor actor = thing(c.size_m);
  Log log = log_with({});
  for (std::size_t i = 0; i < actor.track.size(); ++i) {
    KeyPose& key = actor.track[i];
    key.world_from_actor = log.world_from_rig.at(key.time_s) * at(c.p_rig, 0.0);
    if (i >= c.at_first) key.world_from_actor.translation.y() += 20.0;
  }
  log.actors = {actor};
  const std::vector<std::string> said = sanitize_labels(log);
  EXPECT_EQ(log.actors.empty() ? 0U : log.actors[0].track.size(), c.left);
  ASSERT_EQ(said.size(), c.said[0] == '\0' ? 0U : 1U);
  if (!said.empty()) {
    EXPECT_NE(said[0].find(c.said), std::string::npos) << said[0];
  }
}

INSTANTIATE_TEST_SUITE_P(
    Labels,
    OwnVehicleLabel,
    testing::Values(
        OwnCase{"Around", {4.2, 1.8, 2.0}, {0.0, 0.0, 1.0}, 13, 0, "at 13 of 13 poses, as the ego"},
        OwnCase{"UnderTheRoofRack", {4.2, 1.8, 1.5}, {0.0, 0.0, 0.77}, 13, 0, "13 of 13"},
        OwnCase{"FromTheRearAxle", {4.2, 1.8, 1.5}, {1.4, 0.0, 0.75}, 13, 0, "13 of 13"},
        OwnCase{"SixtyMetresAround", {60.0, 60.0, 5.0}, {20.0, 15.0, 1.0}, 13, 0, "13 of 13"},
        OwnCase{"ForAWhile", {4.2, 1.8, 1.5}, {0.0, 0.0, 0.75}, 4, 9, "4 of 13 poses hold"},
        OwnCase{"Beside", {4.2, 1.8, 1.5}, {0.0, 2.0, 0.75}, 13, 13, ""},
        OwnCase{"BusBefore", {18.0, 2.5, 3.5}, {10.0, 0.0, 1.7}, 13, 13, ""},
        OwnCase{"OnABridge", {4.2, 1.8, 1.5}, {0.0, 0.0, -4.5}, 13, 13, ""},
        OwnCase{"UnderABridge", {4.2, 1.8, 1.5}, {0.0, 0.0, 6.0}, 13, 13, ""}),
    [](const auto& of) { return of.param.name; });

TEST(SanitizedLabels, NothingThatDrivesIsAsLargeAsAHouse) {
  struct Case {
    Vector3d size_m;
    const char* kind;
    double m_per_s;
    bool is_kept;
  };
  for (const Case& c : {Case{{60.0, 6.0, 4.0}, "car", 5.0, false},
                        Case{{60.0, 2.5, 4.0}, "Truck", 5.0, false},
                        Case{{2.5, 60.0, 4.0}, "", 5.0, false},
                        Case{{12.0, 6.0, 4.0}, "car", 5.0, false},
                        Case{{25.0, 2.6, 4.0}, "truck", 5.0, true},
                        Case{{60.0, 2.7, 4.0}, "Tram", 5.0, true},
                        Case{{60.0, 20.0, 9.0}, "hall", 0.0, true}}) {
    SCOPED_TRACE(testing::Message() << c.size_m.transpose() << " " << c.kind);
    Actor actor = thing(c.size_m, 10.0, c.m_per_s);
    actor.kind = c.kind;
    for (KeyPose& key : actor.track) key.world_from_actor.translation.y() += 50.0;
    Log log = log_with(actor);
    const std::vector<std::string> said = sanitize_labels(log);
    EXPECT_EQ(log.actors.size(), c.is_kept ? 1U : 0U);
    ASSERT_EQ(said.size(), c.is_kept ? 0U : 1U);
    if (!said.empty()) {
      EXPECT_NE(said[0].find("m, which drives, allowed at most 30 x 5 m"), std::string::npos) << said[0];
    }
  }
}

TEST(SanitizedLabels, APlaceThatOneLabelAloneTellsIsLeftOut) {
  struct Case {
    std::vector<std::size_t> off;
    Vector3d by_m;
    std::size_t left;
    const char* said;
  };
  for (const Case& c :
       {Case{{6}, {0.0, 60.0, 0.0}, 12, "car: 1 of 13 places are off those before and after"},
        Case{{6}, {0.0, 6.0, 0.0}, 12, "car: 1 of 13 places"},
        Case{{6}, {1e7, 0.0, 0.0}, 12, "car: 1 of 13 places"},
        Case{{0, 4, 12}, {-60.0, 0.0, 0.0}, 10, "car: 3 of 13 places"},
        Case{{1}, {60.0, 0.0, 0.0}, 12, "car: 1 of 13 places"},
        Case{{6, 7}, {0.0, 60.0, 0.0}, 13, "car: gets 60 m far in 0.10 s at 0.60 s, left as it is"},
        Case{{6}, {0.0, 1.0, 0.0}, 13, ""},
        Case{{}, {}, 13, ""}}) {
    SCOPED_TRACE(testing::Message() << c.by_m.transpose() << " " << c.said);
    Actor actor = thing(kCar);
    for (const std::size_t k : c.off) actor.track[k].world_from_actor.translation += c.by_m;
    Log log = log_with(actor);
    const std::vector<std::string> said = sanitize_labels(log);
    ASSERT_EQ(log.actors.size(), 1U);
    EXPECT_EQ(log.actors[0].track.size(), c.left);
    ASSERT_EQ(said.size(), c.said[0] == '\0' ? 0U : 1U);
    if (!said.empty()) {
      EXPECT_NE(said[0].find(c.said), std::string::npos) << said[0];
    }
  }
}

// Labels at 2 Hz of an object that brakes from 30 m/s: each step differs from the median step.
TEST(SanitizedLabels, WhatBrakesIsWhereItSays) {
  Actor actor = thing(kCar, 2.0);
  for (std::size_t k = 0; k < actor.track.size(); ++k) {
    const double time_s = std::min(actor.track[k].time_s, 4.0);
    actor.track[k].world_from_actor.translation.x() = 10.0 + 30.0 * time_s - 0.5 * 7.5 * time_s * time_s;
  }
  Log log = log_with(actor);
  EXPECT_TRUE(sanitize_labels(log).empty());
  EXPECT_EQ(log.actors[0].track.size(), 13U);
}

TEST(SanitizedLabels, OfATimeWithoutAPathAreLeft) {
  Actor actor = thing(kCar);
  for (KeyPose& key : actor.track) key.time_s += 100.0;
  Log log = log_with(actor);
  EXPECT_TRUE(sanitize_labels(log).empty());
  EXPECT_EQ(log.actors.size(), 1U);
}

}  // namespace
}  // namespace simuli

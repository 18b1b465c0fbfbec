// Tests the selection of held-out frames.
#include "io/log/frame_selection.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <set>
#include <string>

#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

using Indices = std::vector<std::size_t>;

/// Returns `frames` pictures and sweeps at 10 Hz of a rig at x(t).
template <class Path>
Log drive(int frames, const Path& x_m) {
  Log log;
  log.folder = "drive.log";
  std::vector<TimedPose> poses;
  for (int i = -2; i <= 2 * frames + 6; ++i) {
    const double time_s = 0.05 * i;
    poses.push_back({time_s, {Eigen::Quaterniond::Identity(), {x_m(time_s), 0.0, 0.0}}});
  }
  log.world_from_rig = Trajectory(std::move(poses));
  for (int i = 0; i < frames; ++i) {
    log.images.push_back({"front", "", 0.1 * i + 0.05, 0.1 * i + 0.05});
    log.sweeps.push_back({"top", "", 0.1 * i, 0.1 * i + 0.1});
  }
  return log;
}
Log steady_drive(int frames) {
  return drive(frames, [](double time_s) { return 8.0 * time_s; });
}

TEST(HeldOutRule, IsEveryNth) {
  const Log log = steady_drive(12);
  EXPECT_EQ(HeldOutRule(log, {}).held_out(log.images), (Indices{4, 9}));
  EXPECT_EQ(HeldOutRule(log, {}).held_out(log.sweeps), (Indices{4, 9}));
  EXPECT_EQ(HeldOutRule(log, {}).training(log.images).size(), 10U);
  EXPECT_TRUE(HeldOutRule(log, {.held_out_every = 0}).held_out(log.images).empty());
}

/// Returns frames of a rig at 10 Hz: a LiDAR and these cameras, each slightly later than the previous one.
Log surround_drive(int moments, const std::vector<std::string>& cameras) {
  Log log = steady_drive(moments);
  log.images.clear();
  Lidar top;
  top.name = "top";
  log.lidars.push_back({.model = top, .rig_from_lidar = {}});
  for (const std::string& camera : cameras) log.cameras.emplace_back().model.name = camera;
  for (int i = 0; i < moments; ++i) {
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      const double time_s = 0.1 * i + 0.1 * static_cast<double>(c) / static_cast<double>(cameras.size());
      log.images.push_back({cameras[c], "", time_s, time_s + 0.01});
    }
  }
  return log;
}

/// Returns the held-out times of each sensor.
std::map<std::string, std::set<int>> moments_held_out(const Log& log, const HeldOutRule& rule) {
  std::map<std::string, std::set<int>> moments;
  for (const std::size_t i : rule.held_out(log.images)) {
    moments[log.images[i].camera].insert(static_cast<int>(log.images[i].time_start_s / 0.1 + 1e-6));
  }
  for (const std::size_t i : rule.held_out(log.sweeps)) {
    moments[log.sweeps[i].lidar].insert(static_cast<int>(log.sweeps[i].time_start_s / 0.1 + 1e-6));
  }
  return moments;
}

TEST(HeldOutRule, HoldsTheSameMomentsOfEverySensorOut) {
  // Numbers of cameras with and without a common factor with N.
  for (const std::size_t cameras : {1U, 2U, 3U, 5U, 6U}) {
    std::vector<std::string> names;
    for (std::size_t c = 0; c < cameras; ++c) names.push_back("camera_" + std::to_string(c));
    const Log log = surround_drive(20, names);
    for (const int every : {2, 3, 4, 5}) {
      std::set<int> moments;
      for (int i = every - 1; i < 20; i += every) moments.insert(i);
      const auto found = moments_held_out(log, HeldOutRule(log, {.held_out_every = every}));
      EXPECT_EQ(found.size(), cameras + 1);
      for (const auto& [sensor, held_out] : found) {
        EXPECT_EQ(held_out, moments) << sensor << " of " << cameras << ", every " << every;
      }
    }
  }
}

TEST(HeldOutRule, KeepsMomentsTogetherWhereFramesAreMissing) {
  Log log = surround_drive(20, {"front", "left", "right"});
  // Some missing pictures, three consecutive missing sweeps.
  std::erase_if(log.images, [](const ImageFrame& frame) {
    const int moment = static_cast<int>(frame.time_start_s / 0.1 + 1e-6);
    return (frame.camera == "front" && moment == 3) || (frame.camera == "left" && moment >= 7 && moment < 9);
  });
  std::erase_if(log.sweeps,
                [](const SweepFrame& s) { return s.time_start_s > 0.95 && s.time_start_s < 1.25; });
  const auto found = moments_held_out(log, HeldOutRule(log, {.held_out_every = 5}));
  const std::set<int> moments{4, 9, 14, 19};
  EXPECT_EQ(found.at("front"), moments);
  EXPECT_EQ(found.at("left"), moments);
  EXPECT_EQ(found.at("right"), moments);
  EXPECT_EQ(found.at("top"), moments);
}

TEST(HeldOutRule, ASensorOfAnotherRateCountsItsOwnFrames) {
  Log log = surround_drive(20, {"front", "left"});
  for (int i = 0; i < 60; ++i) log.images.push_back({"fast", "", i / 30.0, i / 30.0});
  sort_by_time(log);
  const HeldOutRule rule(log, {.held_out_every = 4});
  std::map<std::string, int> held_out;
  for (const std::size_t i : rule.held_out(log.images)) ++held_out[log.images[i].camera];
  EXPECT_EQ(held_out, (std::map<std::string, int>{{"front", 5}, {"left", 5}, {"fast", 15}}));
  EXPECT_EQ(rule.held_out(log.sweeps), (Indices{3, 7, 11, 15, 19}));
}

TEST(HeldOutRule, HoldsASensorOutWhole) {
  const Log log = surround_drive(10, {"front", "left"});
  const FrameSelection frames{.held_out_sensors = {"left"}};
  const HeldOutRule rule(log, frames);
  EXPECT_EQ(held_out_text(frames), "every 5. frame, all of left");
  const std::vector<SensorUse> uses = sensor_uses(log, rule);
  ASSERT_EQ(uses.size(), 3U);
  EXPECT_EQ(uses[0].sensor, "front");
  EXPECT_EQ(uses[0].training, 8U);
  EXPECT_EQ(uses[0].held_out, 2U);
  EXPECT_EQ(uses[1].training, 0U);
  EXPECT_EQ(uses[1].held_out, 10U);
  for (std::size_t i = 0; i < log.images.size(); ++i) {
    EXPECT_EQ(rule.use(i, log.images[i]) == FrameUse::kSensor, log.images[i].camera == "left");
  }
  EXPECT_EQ(other_sensors(log, {"left"}, "--sensors").front(), "front");
  test::expect_error(ErrorKind::kUsage,
                     [&] { (void)HeldOutRule(log, {.held_out_sensors = {"rear"}}); },
                     {"held_out_sensors", "rear", "front, left"});
}

TEST(HeldOutRule, CountsAllPicturesTogetherForScenesThatDid) {
  const Log log = surround_drive(6, {"front", "left"});
  const HeldOutRule rule(log, {.held_out_every = 4, .counts_by_sensor = false});
  EXPECT_EQ(rule.held_out(log.images), (Indices{3, 7, 11}));
  EXPECT_EQ(rule.held_out(log.sweeps), (Indices{3}));
}

TEST(HeldOutRule, IsTheEndOfThePath) {
  const Log log = steady_drive(20);
  const HeldOutRule rule(log, {.held_out_every = 0, .held_out_last = 0.245});
  // The cut is at 1.51 s: sweep 15 ends at 1.6 s, picture 15 is at 1.55 s.
  EXPECT_EQ(rule.held_out(log.sweeps), (Indices{15, 16, 17, 18, 19}));
  EXPECT_EQ(rule.held_out(log.images), (Indices{15, 16, 17, 18, 19}));
  EXPECT_EQ(rule.use(19, log.sweeps[19]), FrameUse::kBeyond);
  EXPECT_EQ(rule.use(14, log.sweeps[14]), FrameUse::kTraining);
}

TEST(HeldOutRule, BothRulesHoldTogetherAndTheEndGoesFirst) {
  const Log log = steady_drive(20);
  const HeldOutRule rule(log, {.held_out_last = 0.245});
  EXPECT_EQ(rule.held_out(log.images), (Indices{4, 9, 14, 15, 16, 17, 18, 19}));
  EXPECT_EQ(rule.use(14, log.images[14]), FrameUse::kBetween);
  EXPECT_EQ(rule.use(19, log.images[19]), FrameUse::kBeyond);
  EXPECT_EQ(rule.training(log.images), (Indices{0, 1, 2, 3, 5, 6, 7, 8, 10, 11, 12, 13}));
}

TEST(HeldOutRule, ASweepThatTheCutGoesThroughIsHeldOut) {
  const Log log = steady_drive(20);
  const HeldOutRule rule(log, {.held_out_every = 0, .held_out_last = 0.26});  // at 1.48 s, in sweep 14
  EXPECT_EQ(rule.use(14, log.sweeps[14]), FrameUse::kBeyond);
  EXPECT_EQ(rule.use(14, log.images[14]), FrameUse::kTraining);  // at 1.45 s
}

TEST(HeldOutRule, TheShareIsOfLengthNotOfTime) {
  // Stops after a second: all later frames are at the end of the trajectory.
  const Log log = drive(40, [](double time_s) { return 8.0 * std::min(time_s, 1.0); });
  const HeldOutRule rule(log, {.held_out_every = 0, .held_out_last = 0.19});
  EXPECT_EQ(rule.training(log.sweeps).size(), 8U);  // the cut is at 0.81 s
}

TEST(HeldOutRule, IsTheMiddleOfThePath) {
  const Log log = steady_drive(20);
  // From 0.65 to 1.35 s: sweeps 6 (0.6 to 0.7 s) and 13 overlap and are held out.
  const HeldOutRule rule(log, {.held_out_every = 0, .held_out_middle = 0.35});
  EXPECT_EQ(rule.held_out(log.sweeps), (Indices{6, 7, 8, 9, 10, 11, 12, 13}));
  EXPECT_EQ(rule.use(10, log.images[10]), FrameUse::kMiddle);
  EXPECT_EQ(rule.use(5, log.images[5]), FrameUse::kTraining);
  EXPECT_EQ(rule.use(14, log.sweeps[14]), FrameUse::kTraining);
}

TEST(HeldOutRule, TheMiddleIsOfLengthNotOfTime) {
  // Rests for the first two seconds: half of the length is at 3 s.
  const Log log = drive(40, [](double time_s) { return 8.0 * std::max(time_s - 2.0, 0.0); });
  const HeldOutRule rule(log, {.held_out_every = 0, .held_out_middle = 0.15});
  EXPECT_EQ(rule.held_out(log.sweeps), (Indices{28, 29, 30, 31}));  // 2.85 to 3.15 s
}

TEST(HeldOutRule, TheEndGoesBeforeTheMiddleAndThatBeforeEveryNth) {
  const Log log = steady_drive(20);
  const FrameSelection frames{.held_out_middle = 0.35, .held_out_last = 0.395};
  const HeldOutRule rule(log, frames);
  EXPECT_EQ(rule.use(4, log.images[4]), FrameUse::kBetween);
  EXPECT_EQ(rule.use(9, log.images[9]), FrameUse::kMiddle);
  EXPECT_EQ(rule.use(11, log.sweeps[11]),
            FrameUse::kMiddle);  // ends at 1.2 s, the last part begins at 1.21 s
  EXPECT_EQ(rule.use(12, log.sweeps[12]), FrameUse::kBeyond);  // belongs to both
  EXPECT_EQ(held_out_text(frames),
            "every 5. frame, the middle 35 % of the path, the last 39.5 % of the path");
  EXPECT_EQ(held_out_text(nothing_held_out(frames)), "");
  EXPECT_TRUE(HeldOutRule(log, nothing_held_out(frames)).held_out(log.images).empty());
}

TEST(HeldOutRule, ARigAtRestHasNoEnd) {
  const Log log = drive(10, [](double) { return 3.0; });
  EXPECT_EQ(HeldOutRule(log, {}).held_out(log.images), (Indices{4, 9}));
  test::expect_input_error([&] { (void)HeldOutRule(log, {.held_out_last = 0.2}); },
                           {"drive.log", "held_out_last", "a path of 0 m"});
  test::expect_input_error([&] { (void)HeldOutRule(log, {.held_out_middle = 0.2}); },
                           {"drive.log", "held_out_middle", "a path of 0 m", "held_out_middle=0"});
}

}  // namespace
}  // namespace simuli

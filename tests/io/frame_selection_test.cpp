// Which frames are held out.
#include "io/log/frame_selection.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

using Indices = std::vector<std::size_t>;

/// `frames` pictures and sweeps at 10 Hz of a rig that is at x(t).
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

TEST(HeldOutRule, IsTheEndOfThePath) {
  const Log log = steady_drive(20);
  const HeldOutRule rule(log, {.held_out_every = 0, .held_out_last = 0.245});
  // The cut is at 1.51 s: sweep 15 ends at 1.6 s, picture 15 is taken at 1.55 s.
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
  // Stops after a second: what it sees from there is of the last of the path, however long it stands.
  const Log log = drive(40, [](double time_s) { return 8.0 * std::min(time_s, 1.0); });
  const HeldOutRule rule(log, {.held_out_every = 0, .held_out_last = 0.19});
  EXPECT_EQ(rule.training(log.sweeps).size(), 8U);  // the cut is at 0.81 s
}

TEST(HeldOutRule, IsTheMiddleOfThePath) {
  const Log log = steady_drive(20);
  // From 0.65 to 1.35 s: sweeps 6 (0.6 to 0.7 s) and 13 are cut through, and held out whole.
  const HeldOutRule rule(log, {.held_out_every = 0, .held_out_middle = 0.35});
  EXPECT_EQ(rule.held_out(log.sweeps), (Indices{6, 7, 8, 9, 10, 11, 12, 13}));
  EXPECT_EQ(rule.use(10, log.images[10]), FrameUse::kMiddle);
  EXPECT_EQ(rule.use(5, log.images[5]), FrameUse::kTraining);
  EXPECT_EQ(rule.use(14, log.sweeps[14]), FrameUse::kTraining);
}

TEST(HeldOutRule, TheMiddleIsOfLengthNotOfTime) {
  // Stands for the first two seconds: half of its way is at 3 s.
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
  EXPECT_EQ(rule.use(12, log.sweeps[12]), FrameUse::kBeyond);  // of both
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

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

TEST(HeldOutRule, ARigAtRestHasNoEnd) {
  const Log log = drive(10, [](double) { return 3.0; });
  EXPECT_EQ(HeldOutRule(log, {}).held_out(log.images), (Indices{4, 9}));
  test::expect_input_error([&] { (void)HeldOutRule(log, {.held_out_last = 0.2}); },
                           {"drive.log", "held_out_last", "a path of 0 m"});
}

}  // namespace
}  // namespace simuli

#include "optim/calibration/path/align.hpp"

#include <gtest/gtest.h>

#include "host/core/base/error.hpp"
#include "tests/io/scratch.hpp"
#include "tests/optim/calibration/street_drive.hpp"

namespace simuli::calibration {
namespace {

namespace fs = std::filesystem;

class StreetLog : public testing::Test {
 protected:
  StreetLog() {
    StreetOptions options;
    options.output = scratch_ / "street.log";
    options.frames = 5;
    options.image_width = 32;
    options.image_height = 18;
    options.moving_car = false;
    log_ = synth_street(options);
  }
  test::Scratch scratch_;
  Log log_;
};

TEST_F(StreetLog, GetsItsPathFromItsSweepsAlone) {
  Log blind = log_;
  blind.world_from_rig = Trajectory({{-0.05, {}}, {0.6, {}}});  // a rig at rest
  AlignOptions options;
  options.spin_sweeps = 0;
  const AlignReport report = align_log(blind, options);
  EXPECT_EQ(report.sweeps, 5U);
  EXPECT_NEAR(report.length_m, 4.0, 0.04);
  EXPECT_LT(report.refined.median_m, 0.02);
  EXPECT_GT(report.refined.planar_share, report.recorded.planar_share);
  EXPECT_FALSE(report.spin.spin);  // not requested

  const fs::path out = scratch_ / "aligned.log";
  write_aligned_log(blind, Trajectory(report.path), out);
  const Log aligned = read_log(out);
  EXPECT_EQ(aligned.world_from_rig.poses().size(), report.path.size());
  EXPECT_EQ(aligned.images.size(), log_.images.size());
  const Lidar& lidar = log_.lidars[0].with_rows();
  EXPECT_EQ(read_sweep(out / aligned.sweeps[2].file, lidar).range,
            read_sweep(log_.folder / log_.sweeps[2].file, lidar).range);
  // existing logs are not replaced
  EXPECT_THROW(write_aligned_log(blind, Trajectory(report.path), out), Error);
}

TEST_F(StreetLog, StartsWhereItsPriorDoes) {
  AlignOptions options;
  options.spin_sweeps = 0;
  options.use_prior = true;
  const AlignReport report = align_log(log_, options);
  for (const TimedPose& knot : report.path) {
    EXPECT_LT((knot.pose.translation - log_.world_from_rig.at(knot.time_s).translation).norm(), 0.03);
  }
}

TEST_F(StreetLog, OneSweepIsNoPath) {
  Log short_log = log_;
  short_log.sweeps.resize(1);
  try {
    (void)align_log(short_log);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInput);
    EXPECT_NE(std::string(error.what()).find("found 1, allowed at least 2"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace simuli::calibration

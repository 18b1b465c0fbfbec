#include "optim/train/judgement.hpp"

#include <gtest/gtest.h>
#include <limits>

namespace simuli {
namespace {

TrainReport sound() {
  TrainReport report;
  report.begin = {.psnr_db = 20.9, .distance_m = 0.52, .drop_accuracy = 0.94};
  report.last = {.iteration = 150, .psnr_db = 26.3, .distance_m = 0.21, .drop_accuracy = 0.96};
  report.camera_particles = report.lidar_particles = 1000;
  report.images = report.sweeps = 8;
  return report;
}

void expect_warning(const TrainReport& report, const std::string& part) {
  const Judgement judgement = judge(report);
  ASSERT_EQ(judgement.warnings.size(), 1U) << part;
  EXPECT_NE(judgement.warnings.front().find(part), std::string::npos) << judgement.warnings.front();
  EXPECT_EQ(judgement.failure, "");
}

TEST(Judgement, SoundTrainingsAreLeftAlone) {
  EXPECT_TRUE(judge(sound()).warnings.empty());
  EXPECT_EQ(judge(sound()).failure, "");
  TrainReport report = sound();  // a few iterations give no verdict
  report.last.iteration = 3;
  report.last.psnr_db = 12.0;
  EXPECT_TRUE(judge(report).warnings.empty());
  report = sound();  // pictures of one colour, which particles have from the start
  for (const double begin_dB : {91.5, std::numeric_limits<double>::infinity()}) {
    report.begin.psnr_db = begin_dB;
    report.last.psnr_db = 54.5;
    EXPECT_TRUE(judge(report).warnings.empty());
    EXPECT_EQ(judge(report).failure, "");
  }
  report = sound();  // no pictures, no sweeps
  report.sweeps = 0;
  report.lidar_particles = 0;
  report.begin.psnr_db = report.last.psnr_db = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(judge(report).warnings.empty());
}

TEST(Judgement, WhatIsWrongIsSaid) {
  TrainReport report = sound();
  report.last.psnr_db = 18.0;
  expect_warning(report, "fell from 20.9 to 18.0 dB");
  report = sound();
  report.last.psnr_db = 21.3;  // pictures in a wrong order
  expect_warning(report, "order of pictures");
  report.first_iteration = 100;  // resumed, with little further gain
  EXPECT_TRUE(judge(report).warnings.empty());
  report = sound();
  report.last.distance_m = 3.9;
  expect_warning(report, "off by 3.9 m");
  report = sound();
  report.last.drop_accuracy = 0.89;
  expect_warning(report, "fell from 94.0 to 89.0 %");
  report = sound();
  report.lidar_particles = 0;
  expect_warning(report, "no sweep has a return");
}

TEST(Judgement, WhatIsNoSceneIsRefused) {
  TrainReport report = sound();
  report.last.psnr_db = 13.6;
  EXPECT_NE(judge(report).failure.find("fell from 20.9 to 13.6 dB"), std::string::npos);
  report = sound();
  report.unsound_particles = 1500;
  EXPECT_NE(judge(report).failure.find("1500 of 2000 particles"), std::string::npos);
}

}  // namespace
}  // namespace simuli

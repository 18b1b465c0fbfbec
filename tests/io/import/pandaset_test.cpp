#include "io/import/pandaset/pandaset.hpp"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <string>

#include "host/core/base/angles.hpp"
#include "io/log/camera_mask.hpp"
#include "tests/io/import/pandaset_folder.hpp"
#include "tests/io/scratch.hpp"
#include "tests/io/survey.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using test::expect_input_error;
using test::expect_survey;
using test::MadeSequence;
using test::Scratch;

constexpr double kStampRounding_s = 3e-7;  // of seconds since 1970 as doubles

TEST(Pandaset, ASequenceBecomesALog) {
  const Scratch scratch;
  const MadeSequence made(scratch / "001");
  PandasetReport report;
  const Log log = import_pandaset({made.root(), scratch / "p.log"}, {}, report);
  PandasetReport surveyed;
  expect_survey(import_pandaset({made.root(), ""}, {}, surveyed), log);
  EXPECT_EQ(surveyed.points.returned, report.points.returned);
  EXPECT_EQ(log.name, "001");
  EXPECT_TRUE(report.gaps.empty());
  ASSERT_EQ(log.world_from_rig.poses().size(), 3U);
  EXPECT_TRUE(log.world_from_rig.poses()[0].pose.matrix().isIdentity(1e-9));
  EXPECT_LT((log.world_from_rig.poses()[2].pose.translation - Eigen::Vector3d(2.0, 0.0, 0.0)).norm(), 1e-5);

  ASSERT_EQ(log.images.size(), 6U);
  EXPECT_NEAR(log.images[0].time_start_s, -0.025, kStampRounding_s);
  EXPECT_NEAR(log.images[0].time_end_s, 0.005, kStampRounding_s);
  const LogCamera& rear = log.camera("back_camera");
  EXPECT_EQ(rear.model.shutter, ShutterKind::kTopToBottom);
  EXPECT_EQ(rear.model.width, 8);
  EXPECT_EQ(rear.model.cx, 4.0);
  const Pose expected = pandaset::rig_from_pandar64() * MadeSequence::rear();
  EXPECT_LT((rear.rig_from_camera.translation - expected.translation).norm(), 1e-5);
  EXPECT_LT(rear.rig_from_camera.rotation.angularDistance(expected.rotation), 1e-6);
  ASSERT_EQ(report.mounts.size(), 2U);
  EXPECT_LT(report.mounts[0].off_m, 1e-5);
  ASSERT_EQ(log.masks.size(), 1U);
  EXPECT_EQ(log.masks[0].camera, "back_camera");
  EXPECT_NEAR(log.hidden.at("back_camera")->hidden_share(),
              2.0 / 6.0,
              1e-9);  // 260 of 1080 rows, scaled to 4.56 of 6

  ASSERT_EQ(log.actors.size(), 2U);
  EXPECT_EQ(log.actors[0].name, "car_0");
  EXPECT_EQ(log.actors[0].size_m, Eigen::Vector3d(1.5, 1.0, 2.0));
  EXPECT_NEAR(log.actors[0].track[1].time_s, 0.1, kStampRounding_s);  // time of the front camera
  EXPECT_EQ(log.actors[1].name, "pedestrian_with_object_1");
  ASSERT_EQ(log.actors[1].track.size(), 3U);
  const double middle_s = MadeSequence::column_s(MadeSequence::kColumns / 2) - 0.05;
  for (std::size_t i = 0; i < 3; ++i) {
    const KeyPose& key = log.actors[1].track[i];
    EXPECT_NEAR(key.time_s, 0.1 * static_cast<double>(i) + middle_s, 1.1e-3) << i;
    const Eigen::Vector3d ahead = key.world_from_actor.rotation * Eigen::Vector3d::UnitX();
    EXPECT_NEAR(std::abs(ahead.y()), 1.0, 1e-6);  // yaw 0.8 is the drive's: the box is across
  }
  EXPECT_EQ(report.labels.kept, 6U);
  EXPECT_EQ(report.labels.repeated, 0U);
  EXPECT_EQ(report.boxes_twice, 2U);
  EXPECT_EQ(report.boxes_by_front, 3U);
}

TEST(Pandaset, Pandar64IsOnItsTablesGrid) {
  const Scratch scratch;
  const MadeSequence made(scratch / "001");
  PandasetReport report;
  const Log log =
      import_pandaset({made.root(), scratch / "p.log", {"front_camera"}, {"pandar64"}}, {}, report);
  ASSERT_EQ(log.lidars.size(), 1U);
  ASSERT_EQ(log.sweeps.size(), 3U);
  EXPECT_NEAR(log.sweeps[1].time_end_s - log.sweeps[1].time_start_s, 0.1, 1e-8);
  EXPECT_TRUE(report.is_clockwise);
  EXPECT_GT(report.spin_agreement, 0.99);
  EXPECT_EQ(report.points.points, 3U * 64U * MadeSequence::kColumns);
  EXPECT_EQ(report.points.unplaced, 0U);
  EXPECT_GT(report.points.returned, report.points.points * 99 / 100);
  const Lidar& lidar = log.lidar("pandar64").with_rows();
  EXPECT_EQ(lidar.spin, SpinDirection::kClockwise);
  const Sweep sweep = read_sweep(log.folder / log.sweeps[1].file, lidar);
  for (std::size_t i = 0; i < sweep.range.size(); ++i) {
    if (sweep.range[i] > 0.0F) {
      ASSERT_NEAR(sweep.range[i], MadeSequence::kTower_m, 0.1) << i;  // due to the beams' own origins
      ASSERT_EQ(sweep.intensity[i], 0.2F);
    }
  }
}

// Half a gap of the close beams is 0.08 degrees: otherwise half of the points would be on the neighbouring
// beam.
TEST(Pandaset, MountingOfThePandar64IsFoundByItsPoints) {
  const Scratch scratch;
  const Pose off{Eigen::Quaterniond(Eigen::AngleAxisd(0.12 * kDegree, Eigen::Vector3d(0.6, -0.8, 0.0))),
                 {0.02, -0.03, 0.015}};
  const MadeSequence made(scratch / "001", off);
  PandasetReport report;
  const Log log =
      import_pandaset({made.root(), scratch / "p.log", {"front_camera"}, {"pandar64"}}, {}, report);
  const Pose rest = off.inverse() * pandaset::rig_from_pandar64().inverse() * log.lidars[0].rig_from_lidar;
  EXPECT_LT(rest.translation.norm(), 0.002);
  EXPECT_LT(rest.rotation.angularDistance(Eigen::Quaterniond::Identity()), 0.005 * kDegree);
  EXPECT_GT(report.mounting.before_rad, 0.03 * kDegree);
  EXPECT_LT(report.mounting.left_rad, 0.005 * kDegree);
  EXPECT_EQ(report.points.unplaced + report.points.echoes, 0U);
}

TEST(Pandaset, MountingStaysWhereRowsDontExplainThePoints) {
  const Lidar lidar = builtin_lidar("ncore_pandaset_pandar64");
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 3000; ++i) points.push_back(10.0 * Lidar::direction(0.37 * i, 1e-4 * (i - 1500)));
  const UnitMounting found = unit_mounting(lidar, points);
  EXPECT_EQ(found.table_from_sensor.translation.norm(), 0.0);
  EXPECT_EQ(found.left_rad, found.before_rad);
  EXPECT_GT(found.left_rad, 0.03 * kDegree);
}

TEST(Pandaset, PandarGtIsTheRaysOfItsPoints) {
  const Scratch scratch;
  const MadeSequence made(scratch / "001");
  PandasetReport report;
  const Log log =
      import_pandaset({made.root(), scratch / "p.log", {"front_camera"}, {"pandargt"}}, {}, report);
  ASSERT_EQ(log.lidars.size(), 1U);
  EXPECT_EQ(ray_count(log.lidars[0].model), 10U);
  ASSERT_EQ(log.sweeps.size(), 2U);
  EXPECT_EQ(report.list_rays, 10U);
  EXPECT_EQ(report.list_points, 18U);
  EXPECT_EQ(report.list_repeated, 2U);
  EXPECT_EQ(report.list_again, 1U);
  for (const SweepFrame& frame : log.sweeps) {
    const Sweep sweep = read_sweep(log.folder / frame.file, log.lidars[0].model);
    for (std::size_t i = 0; i < 10; ++i) {
      EXPECT_NEAR(sweep.range[i], 20.0, 1e-3);
      EXPECT_NEAR(sweep.rays.elevation[i], 0.05, 1e-4);
    }
    EXPECT_NEAR(sweep.rays.azimuth[3], 1.53, 1e-4);
    EXPECT_NEAR(frame.time_start_s + sweep.rays.time_fraction[3] * (frame.time_end_s - frame.time_start_s),
                frame.time_start_s + 0.03,
                1e-6);
  }
  EXPECT_EQ(read_sweep(log.folder / log.sweeps[1].file, log.lidars[0].model).rays.azimuth[8],
            read_sweep(log.folder / log.sweeps[1].file, log.lidars[0].model).rays.azimuth[0]);
}

TEST(Pandaset, WhatIsNotThereIsAGap) {
  const Scratch scratch;
  const MadeSequence made(scratch / "001");
  fs::remove(made.root() / "lidar/01.pkl.gz");
  fs::remove(made.root() / "camera/back_camera/01.jpg");
  fs::remove(made.root() / "annotations/cuboids/00.pkl.gz");
  for (const char* file : {"lidar/02.pkl.gz", "camera/back_camera/02.jpg", "camera/front_camera/02.jpg"})
    fs::remove(made.root() / file);
  PandasetReport report;
  const Log log = import_pandaset({made.root(), scratch / "p.log"}, {}, report);
  EXPECT_EQ(log.images.size(), 3U);
  EXPECT_EQ(log.sweeps.size(), 2U);  // of both LiDARs
  ASSERT_EQ(report.gaps.size(), 4U);
  EXPECT_EQ(report.gaps[0].sensor, "all sensors");
  EXPECT_EQ(report.gaps[0].frames, std::vector<std::size_t>{2});
  EXPECT_EQ(report.gaps[1].sensor, "back_camera");
  EXPECT_EQ(report.gaps[1].frames, std::vector<std::size_t>{1});
  EXPECT_EQ(report.gaps[2].sensor, "cuboids");
  EXPECT_EQ(report.gaps[3].sensor, "lidar");
}

TEST(Pandaset, PartsStandInTheSameWorld) {
  const Scratch scratch;
  const MadeSequence made(scratch / "001");
  PandasetReport report, part_report;
  const Log whole = import_pandaset({made.root(), scratch / "a.log"}, {}, report);
  PandasetOptions options{made.root(), scratch / "b.log"};
  options.first = options.last = 1;
  const Log part = import_pandaset(options, {}, part_report);
  EXPECT_EQ(part.images.size(), 2U);
  EXPECT_EQ(part.start_ns, whole.start_ns);
  EXPECT_EQ(part.images[0].time_start_s, whole.images[2].time_start_s);
  EXPECT_EQ(part.world_from_rig.at(0.1).matrix(), whole.world_from_rig.at(0.1).matrix());
}

TEST(Pandaset, RefusesWhatDoesNotFit) {
  const Scratch scratch;
  const MadeSequence made(scratch / "001");
  const auto refused = [&](PandasetOptions options, const std::vector<std::string>& words) {
    PandasetReport report;
    options.sequence = made.root();
    options.output = scratch / "p.log";
    expect_input_error([&] { (void)import_pandaset(options, {}, report); }, words);
    EXPECT_FALSE(fs::exists(scratch / "p.log"));
  };
  const auto unknown = [&](PandasetOptions options, const char* word) {
    PandasetReport report;
    options.sequence = made.root();
    options.output = scratch / "p.log";
    try {
      (void)import_pandaset(options, {}, report);
      ADD_FAILURE() << word;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kUsage);
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  };
  PandasetOptions options;
  options.first = options.last = 7;
  refused(options, {"frames", "7 to 7", "0 to 2"});
  unknown({{}, {}, {"side"}, {}}, "back_camera, front_camera");
  unknown({{}, {}, {}, {"vlp16"}}, "pandar64, pandargt");

  const std::string labels = "annotations/cuboids/02.pkl.gz", points = "lidar/02.pkl.gz";
  made.write(labels, "no pickle");
  refused({}, {"02.pkl.gz", "pickle"});
  made.write(labels, gzip(test::MadeTable{{{"yaw", {0.0}}}, {}}.pickled()));
  refused({}, {"02.pkl.gz", "uuid"});
  fs::remove(made.root() / labels);
  made.write(points,
             gzip(test::MadeTable{
                 {{"x", {NAN}}, {"y", {0.0}}, {"z", {0.0}}, {"i", {0.0}}, {"t", {1.6e9}}, {"d", {0.0}}},
                 {}}.pickled()));
  refused({}, {"02.pkl.gz", "point 0: x", "nan"});
  made.write(points, "");
  refused({}, {"02.pkl.gz"});
  fs::remove(made.root() / points);
  made.write("camera/back_camera/timestamps.json", "[1600000000.0]");
  refused({}, {"timestamps.json", "1", "3, one for each pose"});
  made.write("camera/back_camera/timestamps.json", "[1600000000.1, 1600000000.1, 1600000000.2]");
  refused({}, {"timestamps.json", "[1]", "times that rise"});
  made.write("camera/front_camera/poses.json", "{}");
  refused({}, {"poses.json", "root"});
  fs::remove_all(made.root() / "camera");
  refused({}, {"camera", "front_camera and others"});
}

/// First four frames of the real sequence 002: six cameras, both LiDARs, boxes.
TEST(Pandaset, FirstFramesOf002) {
  const char* const data = std::getenv("SIMULI_DATA");
  if (data == nullptr) GTEST_SKIP() << "not run: four frames of PandaSet, SIMULI_DATA is not set";
  const fs::path sequence = fs::path(data) / "pandaset" / "002_first4";
  if (!fs::exists(sequence)) GTEST_SKIP() << "not run: four frames of PandaSet, not below SIMULI_DATA";
  const Scratch scratch;
  PandasetReport report;
  const Log log = import_pandaset({sequence, scratch / "p.log"}, {}, report);
  EXPECT_EQ(log.images.size(), 24U);
  EXPECT_EQ(log.sweeps.size(), 7U);  // two frames contain the PandarGT's first sweep
  EXPECT_EQ(report.list_again, 1U);
  EXPECT_EQ(report.points.points, 424747U);
  EXPECT_LT(report.points.unplaced + report.points.echoes, 20U);  // 0.7 % with the published mounting
  EXPECT_LT(report.mounting.left_rad, 0.005 * kDegree);
  EXPECT_GT(report.spin_agreement, 0.995);
  EXPECT_TRUE(report.is_clockwise);
  EXPECT_EQ(report.list_rays, 60599U);
  for (const PandasetMount& mount : report.mounts) {
    EXPECT_LT(mount.off_m, 0.005) << mount.camera;
    EXPECT_LT(mount.off_rad, 0.05 * kDegree) << mount.camera;
  }
  EXPECT_EQ(log.masks.size(), 1U);
  EXPECT_NEAR(log.hidden.at("back_camera")->hidden_share(), 260.0 / 1080.0, 1e-6);
  // The vehicle moves forward.
  const Pose& last = log.world_from_rig.poses().back().pose;
  EXPECT_GT(last.translation.x(), 5.0 * std::abs(last.translation.y()));
}

}  // namespace
}  // namespace simuli

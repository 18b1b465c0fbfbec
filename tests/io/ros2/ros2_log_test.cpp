// Tests the street as recorded by simuli for ROS 2, and back.
#include "io/import/ros2/ros2_log.hpp"

#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <numbers>
#include <string>

#include "io/bag/mcap_writer.hpp"
#include "io/base/file.hpp"
#include "io/picture/image.hpp"
#include "io/ros2/messages.hpp"
#include "io/ros2/recording.hpp"
#include "io/synth/street.hpp"
#include "tests/io/ros2/ros2_street.hpp"

namespace simuli {
namespace ros2_log_test {

namespace fs = std::filesystem;
using namespace test;  // NOLINT(google-build-using-namespace)

/// Records like `simuli render -o x.mcap`.
void record(const Log& log, const fs::path& file, BagPictures pictures) {
  Ros2Drive drive{log.world_from_rig, {}, log.actors, kStart_ns};
  for (const LogCamera& c : log.cameras) drive.sensors.emplace_back(c.model, c.rig_from_camera);
  for (const LogLidar& l : log.lidars) drive.sensors.emplace_back(l.model, l.rig_from_lidar);
  Ros2Recording recording(file, drive, McapWriter::Compression::kNone);
  for (const SweepFrame& frame : log.sweeps) {
    PointCloud cloud;
    cloud.columns = {"x", "y", "z", "intensity", "ring", "time"};
    const std::vector<Point> points = points_of(log, frame);
    cloud.values.resize(static_cast<Eigen::Index>(points.size()), 6);
    for (std::size_t i = 0; i < points.size(); ++i) {
      cloud.values.row(static_cast<Eigen::Index>(i)) << points[i].p.x(), points[i].p.y(), points[i].p.z(),
          points[i].intensity, points[i].row, points[i].time_s;
    }
    recording.add_cloud(frame.lidar, frame.time_start_s, cloud);
  }
  for (const ImageFrame& frame : log.images)
    recording.add_picture(frame.camera, frame.time_start_s, read_image(log.folder / frame.file), pictures);
  recording.finish();
}

TEST(Ros2Log, TheStreetComesBack) {
  const Scratch scratch;
  const Log log = street(scratch);
  for (const BagPictures pictures : {BagPictures::kPng, BagPictures::kRaw}) {
    record(log, scratch / "street.mcap", pictures);
    Ros2Report report;
    const Log back = imported(
        options_for(
            log, scratch / "street.mcap", scratch / fmt::format("back{}.log", static_cast<int>(pictures))),
        report);
    EXPECT_EQ(back.start_ns, kStart_ns);
    EXPECT_EQ(report.points.unplaced, 0U);
    EXPECT_EQ(report.points.echoes, 0U);
    EXPECT_EQ(report.unposed, 0U);
    expect_same_sweeps(log, back);
    EXPECT_EQ(back.lidars.at(0).model, log.lidars.at(0).model);
    EXPECT_EQ(back.cameras.at(0).model, log.cameras.at(0).model);
    EXPECT_TRUE(
        back.lidars.at(0).rig_from_lidar.matrix().isApprox(log.lidars.at(0).rig_from_lidar.matrix(), 1e-12));
    EXPECT_TRUE(back.cameras.at(0).rig_from_camera.matrix().isApprox(
        log.cameras.at(0).rig_from_camera.matrix(), 1e-12));
    for (const SweepFrame& frame : log.sweeps) {
      EXPECT_TRUE(back.world_from_rig.at(frame.time_start_s)
                      .matrix()
                      .isApprox(log.world_from_rig.at(frame.time_start_s).matrix(), 1e-6));
    }
    ASSERT_EQ(back.images.size(), log.images.size());
    for (std::size_t i = 0; i < log.images.size(); ++i) {
      EXPECT_NEAR(back.images[i].time_start_s, log.images[i].time_start_s, 1e-9);
      EXPECT_EQ(read_image(back.folder / back.images[i].file).data,
                read_image(log.folder / log.images[i].file).data);
    }
  }
}

TEST(Ros2Log, BarePointsAreThoseOfTheClouds) {
  const Scratch scratch;
  const Log log = street(scratch);
  const fs::path file = scratch / "a.mcap";
  record(log, file, BagPictures::kPng);
  const Ros2Clouds clouds = read_ros2_clouds(file, "/top/points", 2, 1);
  ASSERT_EQ(clouds.first.size(), 2U);
  ASSERT_EQ(clouds.spread.size(), 1U);
  EXPECT_EQ(read_ros2_clouds(file, "/top/points", 9, 9).spread.size(), log.sweeps.size());
  const std::vector<Point> second = points_of(log, log.sweeps[1]);
  ASSERT_EQ(clouds.first[1].size(), second.size());
  for (std::size_t i = 0; i < second.size(); ++i)
    EXPECT_LT((clouds.first[1][i] - second[i].p).norm(), kStored_m);
  try {
    (void)read_ros2_clouds(file, "/front/camera_info", 1, 1);
    ADD_FAILURE() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kUsage);
    EXPECT_NE(std::string(error.what()).find("/top/points"), std::string::npos) << error.what();
  }
}

TEST(Ros2Log, WhatCanNotBeToldIsAskedFor) {
  const Scratch scratch;
  const Log log = street(scratch);
  const fs::path file = scratch / "a.mcap";
  record(log, file, BagPictures::kPng);
  const Ros2Options whole = options_for(log, file, scratch / "out.log");
  const auto refused = [&](auto change,
                           const std::vector<std::string>& words,
                           ErrorKind kind = ErrorKind::kInput) {
    Ros2Options options = whole;
    change(options);
    Ros2Report report;
    try {
      (void)imported(options, report);
      ADD_FAILURE() << "nothing was thrown";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), kind) << error.what();
      for (const std::string& word : words)
        EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << word << " in " << error.what();
    }
    EXPECT_FALSE(fs::exists(options.output));
  };
  refused([](auto& o) { o.lidars.clear(); }, {"a.mcap", "/top/points", "--lidar", "--no-lidars"});
  refused([](auto& o) { o.lidars[0].topic = "/nothing"; },
          {"--lidar", "/nothing", "/top/points"},
          ErrorKind::kUsage);
  refused([](auto& o) { o.cameras = {"/front/camera_info"}; },
          {"--cameras", "/front/image_raw/compressed"},
          ErrorKind::kUsage);
  refused([](auto& o) { o.lidars[0].table = builtin_lidar("velodyne_vlp16"); },
          {"/top/points", "rings", "velodyne_vlp16"});
  refused([](auto& o) { o.lidars[0].table = builtin_lidar("velodyne_vls128"); },
          {"/top/points", "ring", "is it that sensor", "Nearest built-in table: ", "fit beams"});
  refused([](auto& o) { o.point_time = "time:ms"; }, {"/top/points", "no turn"});
  refused([](auto& o) { o.point_time = "tick:s"; }, {"tick", "x, y, z, intensity, ring, time"});
  refused([](auto& o) { o.point_time = "time:min"; }, {"--point-time"}, ErrorKind::kUsage);
  refused([](auto& o) { o.intensity = "intensity:1"; }, {"field intensity", "0 to 1", "--intensity"});
  refused([](auto& o) { o.rig_frame = "chassis"; },
          {"front_optical_frame", "chassis", "base_link", "--mount"});
  refused([](auto& o) { o.world_frame = "utm"; }, {"base_link", "utm"});
  refused([](auto& o) { o.odometry = "/odom"; }, {"--odometry", "/odom"}, ErrorKind::kUsage);
  Ros2Options at_rest = whole;
  at_rest.without_poses = true;
  at_rest.mounts["/top/points"].position_m = {0.0, 0.0, 3.0};
  at_rest.shutters["/front/image_raw/compressed"] = {ShutterKind::kTopToBottom, 0.02};
  Ros2Report report;
  const Log rest = imported(at_rest, report);
  EXPECT_EQ(rest.lidars.at(0).rig_from_lidar.translation.z(), 3.0);
  EXPECT_EQ(rest.cameras.at(0).model.shutter, ShutterKind::kTopToBottom);
  EXPECT_NEAR(rest.images.at(0).time_end_s - rest.images.at(0).time_start_s, 0.02, 1e-9);
  EXPECT_TRUE(rest.world_from_rig.at(0.1).matrix().isIdentity());
}

}  // namespace ros2_log_test
}  // namespace simuli

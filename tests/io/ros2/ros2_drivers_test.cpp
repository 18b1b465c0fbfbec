// Tests the street as recorded by other drivers with ROS 2.
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>
#include <string>

#include "io/bag/mcap_writer.hpp"
#include "io/import/ros2/ros2_lidar.hpp"
#include "io/ros2/messages.hpp"
#include "tests/io/ros2/ros2_street.hpp"

namespace simuli {
namespace ros2_drivers_test {

namespace fs = std::filesystem;
using ros2::PointField;
using namespace test;  // NOLINT(google-build-using-namespace)

/// Format of a driver's clouds.
struct Driver {
  const char* name;
  std::vector<PointField> fields;
  std::uint32_t step;
  bool is_ring_reversed;
  bool is_stamped_at_end;
  bool is_turned = false;  // points in other axes than the table's
};

/// Ouster's lidar frame in its sensor frame.
const Pose kTurned{Eigen::Quaterniond{0.0, 0.0, 0.0, 1.0}, {0.0, 0.0, 0.036}};

template <class T>
void put(std::string& to, std::size_t at, double value) {
  const T v = static_cast<T>(std::is_integral_v<T> ? std::round(value) : value);
  std::memcpy(to.data() + at, &v, sizeof v);
}

const std::vector<Driver>& drivers() {
  constexpr auto f32 = PointField::kFloat32;
  const auto xyz = [](std::vector<PointField> more) {
    std::vector<PointField> fields{{"x", 0, f32}, {"y", 4, f32}, {"z", 8, f32}};
    fields.insert(fields.end(), more.begin(), more.end());
    return fields;
  };
  static const std::vector<Driver> all{
      {"velodyne",
       xyz({{"intensity", 12, f32}, {"ring", 16, PointField::kUint16}, {"time", 18, f32}}),
       22,
       true,
       true},
      {"ouster",
       xyz({{"intensity", 16, f32},
            {"t", 20, PointField::kUint32},
            {"reflectivity", 24, PointField::kUint16},
            {"ring", 26, PointField::kUint16},
            {"ambient", 28, PointField::kUint16},
            {"range", 32, PointField::kUint32}}),
       48,
       false,
       false,
       true},
      {"hesai",
       xyz({{"intensity", 16, f32},
            {"timestamp", 24, PointField::kFloat64},
            {"ring", 32, PointField::kUint16}}),
       48,
       false,
       false},
      {"robosense",
       xyz({{"intensity", 16, PointField::kUint8},
            {"ring", 18, PointField::kUint16},
            {"timestamp", 24, PointField::kFloat64}}),
       32,
       true,
       true},
      {"nebula",
       xyz({{"intensity", 12, PointField::kUint8},
            {"return_type", 13, PointField::kUint8},
            {"channel", 14, PointField::kUint16},
            {"time_stamp", 28, PointField::kUint32}}),
       32,
       false,
       false}};
  return all;
}

std::string cloud_of(const Log& log, const SweepFrame& frame, const Driver& driver) {
  const std::vector<Point> points = points_of(log, frame);
  const int rows = lidar_of(log).row_count();
  ros2::PointCloudMessage cloud;
  const double start_s = frame.time_start_s, stamp_s = driver.is_stamped_at_end ? frame.time_end_s : start_s;
  cloud.header = {kStart_ns + static_cast<std::int64_t>(std::llround(1e9 * stamp_s)), "lidar_frame"};
  cloud.height = 1;
  cloud.width = static_cast<std::uint32_t>(points.size()) + 1;
  cloud.fields = driver.fields;
  cloud.point_step = driver.step;
  cloud.row_step = cloud.width * cloud.point_step;
  std::string data(cloud.row_step, '\0');  // with a last point without a return
  for (std::size_t i = 0; i < points.size(); ++i) {
    Point p = points[i];
    if (driver.is_turned) p.p = kTurned.inverse() * p.p;
    const double after_s = start_s + p.time_s - stamp_s;
    for (const PointField& field : driver.fields) {
      const std::size_t at = i * driver.step + field.offset;
      double value = 0.0;
      if (field.name == "x") value = p.p.x();
      if (field.name == "y") value = p.p.y();
      if (field.name == "z") value = p.p.z();
      if (field.name == "intensity" || field.name == "reflectivity") value = 255.0 * p.intensity;
      if (field.name == "intensity" && std::string(driver.name) == "ouster") value = 4000.0;
      if (field.name == "ring" || field.name == "channel")
        value = driver.is_ring_reversed ? rows - 1 - p.row : p.row;
      if (field.name == "time") value = after_s;
      if (field.name == "t" || field.name == "time_stamp") value = 1e9 * after_s;
      if (field.name == "timestamp") value = 1e-9 * static_cast<double>(cloud.header.stamp_ns) + after_s;
      switch (field.datatype) {
        case PointField::kUint8:
          put<std::uint8_t>(data, at, value);
          break;
        case PointField::kUint16:
          put<std::uint16_t>(data, at, value);
          break;
        case PointField::kUint32:
          put<std::uint32_t>(data, at, value);
          break;
        case PointField::kFloat32:
          put<float>(data, at, value);
          break;
        default:
          put<double>(data, at, value);
      }
    }
  }
  cloud.data = data;
  return to_cdr(cloud);
}

/// Records only clouds by these drivers in turns, the trajectory as odometry of a frame fixed to the rig, and
/// the messages of `others`.
void record_by(const std::vector<Driver>& drivers,
               const Log& log,
               const fs::path& file,
               const std::function<void(McapWriter&)>& others = {}) {
  const Driver& driver = drivers.front();
  McapWriter mcap(file, "ros2", McapWriter::Compression::kNone);
  const auto channel = [&](const std::string& topic, const char* type) {
    return mcap.add_channel({topic,
                             type,
                             "ros2msg",
                             ros2::kPointCloud2 == std::string(type) ? ros2::definition_of(type) : "",
                             "cdr"});
  };
  const std::uint16_t clouds = channel("/points", ros2::kPointCloud2),
                      tf = channel("/tf_static", ros2::kTfMessage),
                      odometry = channel("/odom", ros2::kOdometry);
  const Pose rig_from_imu{Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ())),
                          {1.0, 0.5, 0.2}};
  const std::vector<ros2::TransformMessage> fixed{
      {{kStart_ns, "base_link"}, "table_frame", log.lidars.at(0).rig_from_lidar},
      {{kStart_ns, "table_frame"}, "/lidar_frame", driver.is_turned ? kTurned : Pose{}},
      {{kStart_ns, "base_link"}, "imu", rig_from_imu}};
  mcap.add_message(tf, kStart_ns, ros2::to_cdr(fixed));
  for (const TimedPose& pose : log.world_from_rig.poses()) {
    const std::int64_t ns = kStart_ns + static_cast<std::int64_t>(std::llround(1e9 * pose.time_s));
    mcap.add_message(odometry,
                     static_cast<std::uint64_t>(ns),
                     ros2::to_cdr(ros2::OdometryMessage{{ns, "odom"}, "imu", pose.pose * rig_from_imu}));
  }
  if (others) others(mcap);
  for (std::size_t i = 0; i < log.sweeps.size(); ++i)
    mcap.add_message(clouds, kStart_ns, cloud_of(log, log.sweeps[i], drivers[i % drivers.size()]));
  mcap.finish();
}

TEST(Ros2Log, DriversOfOthersAreUnderstood) {
  const Scratch scratch;
  const Log log = street(scratch);
  for (const Driver& driver : drivers()) {
    SCOPED_TRACE(driver.name);
    const fs::path file = scratch / fmt::format("{}.mcap", driver.name);
    record_by({driver}, log, file);
    Ros2Options options = options_for(log, file, scratch / fmt::format("{}.log", driver.name));
    options.lidars[0].topic = "/points";
    options.lidars[0].frame = driver.is_turned ? "table_frame" : "";
    // A table of a differently cabled sensor: the points have priority.
    options.lidars[0].table.azimuth_first = 1.0;
    options.lidars[0].table.spin = SpinDirection::kCounterClockwise;
    Ros2Report report;
    const Log back = imported(options, report);
    EXPECT_EQ(report.points.unplaced, 0U);
    EXPECT_EQ(lidar_of(back).spin, lidar_of(log).spin);
    // The cut of the sweep is found up to a part of a column: rays are as measured, in any column.
    EXPECT_LT(std::abs(std::remainder(lidar_of(back).azimuth_first - lidar_of(log).azimuth_first,
                                      2.0 * std::numbers::pi)),
              2.0 * std::numbers::pi / lidar_of(log).columns);
    EXPECT_EQ(report.points.returned, report.points.points);
    ASSERT_EQ(back.sweeps.size(), log.sweeps.size());
    for (std::size_t s = 0; s < log.sweeps.size(); ++s)
      EXPECT_NEAR(back.sweeps[s].time_start_s + 1e-9 * static_cast<double>(back.start_ns - kStart_ns),
                  log.sweeps[s].time_start_s,
                  1e-6);
    options.lidars[0].table = lidar_of(log);
    options.output = scratch / fmt::format("{}_exact.log", driver.name);
    expect_same_sweeps(log, imported(options, report));
    for (const SweepFrame& frame : log.sweeps) {
      const double time_s = frame.time_start_s - 1e-9 * static_cast<double>(back.start_ns - kStart_ns);
      EXPECT_TRUE(back.world_from_rig.at(time_s).matrix().isApprox(
          log.world_from_rig.at(frame.time_start_s).matrix(), 1e-6));
    }
  }
}

TEST(Ros2Log, WhatNobodyAskedForEndsNothing) {
  const Scratch scratch;
  const Log log = street(scratch);
  const auto others = [](McapWriter& mcap) {
    const auto add = [&](const std::string& topic, const char* type, const std::string& message) {
      mcap.add_message(mcap.add_channel({topic, type, "", "", "cdr"}), kStart_ns, message);
    };
    const double nan = std::nan("");
    const auto at = [](const char* parent, const char* child, const Pose& pose) {
      return ros2::TransformMessage{{kStart_ns, parent}, child, pose};
    };
    const std::vector<ros2::TransformMessage> bad{
        at("base_link", "wheel", {Eigen::Quaterniond::Identity(), {nan, 0.0, 0.0}}),
        at("base_link", "arm", {Eigen::Quaterniond(0.0, 0.0, 0.0, 0.0), {0.0, 0.0, 0.0}}),
        at("base_link", "gnss", {Eigen::Quaterniond(1.014, 0.0, 0.0, 0.0), {0.0, 0.0, 0.0}}),
        at("front", "tag", {}),
        at("rear", "tag", {})};
    add("/tf", ros2::kTfMessage, ros2::to_cdr(bad));
    ros2::PointCloudMessage radar;
    radar.header = {kStart_ns, "radar"};
    radar.is_bigendian = true;
    add("/radar", ros2::kPointCloud2, ros2::to_cdr(radar));
    ros2::CameraInfoMessage zoom;
    zoom.header = {kStart_ns, "ptz"};
    for (const double f : {50.0, 80.0}) {
      zoom.k = {f, 0.0, 4.0, 0.0, f, 3.0, 0.0, 0.0, 1.0};
      add("/ptz/camera_info", ros2::kCameraInfo, ros2::to_cdr(zoom));
    }
    ros2::ImageMessage none;
    none.encoding = "mono8";
    add("/ptz/image_raw", ros2::kImage, ros2::to_cdr(none));
    ros2::OdometryMessage lost{
        {kStart_ns, "odom"}, "wheels", {Eigen::Quaterniond::Identity(), {nan, 0.0, 0.0}}};
    add("/wheels", ros2::kOdometry, ros2::to_cdr(lost));
    for (const char* type : {ros2::kPointCloud2, ros2::kImage, ros2::kCameraInfo, ros2::kTfMessage})
      add(std::string("/broken/") + type, type, "\1\2\3\4\5");
    none.header.frame_id = "nowhere";
    add("/loose/image_raw", ros2::kImage, ros2::to_cdr(none));
    zoom.width = zoom.height = 8;
    add("/loose/camera_info", ros2::kCameraInfo, ros2::to_cdr(zoom));
  };
  record_by({drivers().front()}, log, scratch / "robot.mcap", others);
  Ros2Options options = options_for(log, scratch / "robot.mcap", scratch / "robot.log");
  options.lidars[0].topic = "/points";
  options.odometry = "/odom";
  Ros2Report report;
  expect_same_sweeps(log, imported(options, report));
  const std::string reported = fmt::format("{}", fmt::join(report.notes, "\n"));
  for (const char* word : {"3 transforms",
                           "tag has several parents",
                           "/radar, no --lidar",
                           "/ptz/image_raw, /ptz",
                           "left out: 1 messages of /broken/sensor_msgs/msg/PointCloud2: ",
                           "left out: 1 messages of /broken/tf2_msgs/msg/TFMessage: ",
                           "left out: /loose/image_raw: ",
                           "--mount /loose/image_raw"})
    EXPECT_NE(reported.find(word), std::string::npos) << word << " is missing in: " << reported;

  // A survey reports the same and writes no files.
  options.output.clear();
  report = {};
  const Log surveyed = import_ros2(options, {}, report);
  EXPECT_EQ(surveyed.sweeps.size(), 3U);
  EXPECT_EQ(surveyed.lidars.size(), 1U);
  const std::string survey = fmt::format("{}", fmt::join(report.notes, "\n"));
  for (const char* word : {"clouds /points: 3 messages, 10 Hz, 1700000000.223 to 1700000000.423 s",
                           "pictures /ptz/image_raw: 1 messages",
                           "odometry /odom: ",
                           "frames: ",
                           "LiDAR points: /points, 10 Hz",
                           "left out: /radar, no --lidar"})
    EXPECT_NE(survey.find(word), std::string::npos) << word << " is missing in: " << survey;
  options.lidars.clear();
  EXPECT_TRUE(import_ros2(options, {}, report).sweeps.empty());
  EXPECT_NE(report.notes.back().find("refused: "), std::string::npos) << report.notes.back();
  options.lidars = {{"/points", lidar_of(log)}};

  // The same with a selection of topics: the wheel odometry without data is then no candidate.
  options.odometry = {};
  options.ignore = {"/wheels", "/radar", "/ptz/image_raw"};
  options.output = scratch / "ignored.log";
  report = {};
  expect_same_sweeps(log, imported(options, report));
  options.ignore = {};
  options.topics = {"/points", "/odom", "/tf_static"};
  options.output = scratch / "topics.log";
  report = {};
  expect_same_sweeps(log, imported(options, report));
  options.topics = {"/pionts"};
  EXPECT_THROW((void)imported(options, report), Error);
}

TEST(Ros2Log, TheRigStandsUprightInTheWorld) {
  const Scratch scratch;
  const Log log = street(scratch);
  const Eigen::Quaterniond ned(0.0, std::sqrt(0.5), std::sqrt(0.5), 0.0);
  const Eigen::Quaterniond slope(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX()));
  // A slope along the road is kept; a constant tilt in a bend belongs to the frame.
  for (const auto& [name, turn, bend, is_levelled] : {std::tuple("ned.mcap", ned, 0.0, true),
                                                      std::tuple("slope.mcap", slope, 0.0, false),
                                                      std::tuple("odom.mcap", slope, 2.0, true)}) {
    Log turned = log;
    std::vector<TimedPose> poses = log.world_from_rig.poses();
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const double yaw = bend * static_cast<double>(i) / static_cast<double>(poses.size());
      poses[i].pose = Pose{turn, Eigen::Vector3d::Zero()} * poses[i].pose;
      poses[i].pose.rotation = poses[i].pose.rotation * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
    }
    turned.world_from_rig = Trajectory(std::move(poses));
    const fs::path file = scratch / name;
    record_by({drivers().front()}, turned, file);
    Ros2Options options = options_for(log, file, "");
    options.lidars[0].topic = "/points";
    Ros2Report report;
    const Log back = import_ros2(options, {}, report);
    const Eigen::Vector3d up = back.world_from_rig.poses().front().pose.rotation * Eigen::Vector3d::UnitZ();
    const std::string reported = fmt::format("{}", fmt::join(report.notes, "\n"));
    EXPECT_EQ(up.z() > 0.999, is_levelled) << reported;
    EXPECT_EQ(reported.find("base_link is upright") != std::string::npos, is_levelled) << reported;
    EXPECT_EQ(reported.find("base_link leans by ") != std::string::npos, !is_levelled) << reported;
  }
}

TEST(Ros2Log, RectifiedPicturesHaveTheLensOfP) {
  const Scratch scratch;
  ros2::CameraInfoMessage info;
  const auto import = [&](const char* output) {
    McapWriter mcap(scratch / "zed.mcap", "ros2", McapWriter::Compression::kNone);
    const auto add = [&](const std::string& topic, const char* type, const std::string& message) {
      mcap.add_message(mcap.add_channel({topic, type, "", "", "cdr"}), kStart_ns, message);
    };
    const std::string pixels(48, 'x');
    ros2::ImageMessage picture;
    picture.header = {kStart_ns, "left"};
    picture.height = 6;
    picture.width = picture.step = 8;
    picture.encoding = "mono8";
    picture.data = pixels;
    add("/left/camera_info", ros2::kCameraInfo, ros2::to_cdr(info));
    add("/left/image_rect_color", ros2::kImage, ros2::to_cdr(picture));
    mcap.finish();
    Ros2Options options;
    options.recording = scratch / "zed.mcap";
    options.output = scratch / output;
    options.without_poses = true;
    options.mounts["/left/image_rect_color"] = {};
    Ros2Report report;
    return imported(options, report).cameras.at(0).model;
  };
  info.header = {kStart_ns, "left"};
  info.width = 8;
  info.height = 6;
  info.distortion_model = "rational_polynomial";
  info.k = {9, 0, 3.5, 0, 9, 2.5, 0, 0, 1};
  info.r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.d.assign(8, 0.0);
  EXPECT_EQ(import("undistorted.log").fx, 9.0);  // without P, K is used
  info.d[0] = 0.1;
  EXPECT_THROW((void)import("no_p.log"), Error);
  info.p = {7, 0, 3.25, 0, 0, 7.5, 2.5, 0, 0, 0, 1, 0};
  const Camera camera = import("p.log");
  EXPECT_EQ(camera.lens.kind(), LensKind::kPinhole);
  EXPECT_EQ(camera.fx, 7.0);
  EXPECT_EQ(camera.fy, 7.5);
  EXPECT_EQ(camera.cx, 3.75);
  info.r = {0, -1, 0, 1, 0, 0, 0, 0, 1};
  EXPECT_THROW((void)import("turned.log"), Error);
}

TEST(Ros2Log, NothingOnThePathIsAnError) {
  const Scratch scratch;
  Log log = street(scratch);
  record_by({drivers().front()}, log, scratch / "a.mcap", [](McapWriter& mcap) {
    ros2::TransformMessage moving;
    moving.header = {kStart_ns + 3'600'000'000'000, "map"};
    moving.child_frame_id = "base_link";
    const auto tf = mcap.add_channel({"/tf", ros2::kTfMessage, "", "", "cdr"});
    for (int i = 0; i < 3; ++i) {
      moving.header.stamp_ns += 100'000'000;
      moving.parent_from_child.translation.x() += 1.0;
      mcap.add_message(tf, kStart_ns, ros2::to_cdr(std::vector{moving}));
    }
  });
  Ros2Options options = options_for(log, scratch / "a.mcap", scratch / "a.log");
  options.lidars[0].topic = "/points";
  Ros2Report report;
  expect_error(ErrorKind::kNothing,
               [&] { (void)imported(options, report); },
               {"stamps", "none on the path", "one clock"});
  EXPECT_FALSE(fs::exists(scratch / "a.log"));
}

TEST(Ros2Log, CloudsOfATopicMayBeLaidOutOtherwise) {
  const Scratch scratch;
  const Log log = street(scratch);
  std::vector<Driver> two;
  for (const Driver& driver : drivers()) {
    if (driver.name == std::string("hesai") || driver.name == std::string("nebula")) two.push_back(driver);
  }
  ASSERT_EQ(two.size(), 2U);
  for (int first = 0; first < 2; ++first) {
    SCOPED_TRACE(two[0].name);
    record_by(two, log, scratch / "both.mcap");
    Ros2Options options =
        options_for(log, scratch / "both.mcap", scratch / fmt::format("both_{}.log", two[0].name));
    options.lidars[0].topic = "/points";
    options.lidars[0].table = lidar_of(log);
    Ros2Report report;
    expect_same_sweeps(log, imported(options, report));
    std::swap(two[0], two[1]);
  }
}

TEST(Ros2Log, AbsoluteTimesTellTheirUnit) {
  ros2::PointCloudMessage cloud;
  cloud.header = {kStart_ns, "lidar"};
  cloud.height = cloud.width = 1;
  cloud.fields = {{"x", 0, PointField::kFloat32},
                  {"y", 4, PointField::kFloat32},
                  {"z", 8, PointField::kFloat32},
                  {"timestamp", 12, PointField::kFloat64}};
  cloud.point_step = cloud.row_step = 20;
  for (const double per_s : {1.0, 1e3, 1e6, 1e9}) {
    std::string data(20, '\0');
    put<float>(data, 0, 5.0);
    put<double>(data, 12, (1e-9 * static_cast<double>(kStart_ns) + 0.025) * per_s);
    cloud.data = data;
    const ros2::CloudFields fields = ros2::find_cloud_fields(cloud, {}, "a.mcap", "/points");
    const std::vector<ros2::CloudPoint> points = ros2::points_of(cloud, fields, "a.mcap", "/points");
    ASSERT_EQ(points.size(), 1U);
    EXPECT_NEAR(points[0].time_s, 0.025, 1e-5) << per_s;
  }
}

TEST(Ros2Log, RingsOfSomePointsAloneAreRefused) {
  const Scratch scratch;
  const Log log = street(scratch);
  std::vector<ros2::CloudPoint> sweep;
  for (const Point& point : points_of(log, log.sweeps.front())) {
    ros2::CloudPoint out;
    out.position = point.p;
    out.ring = sweep.size() % 2 == 0 ? point.row : -1;
    out.time_s = point.time_s;
    sweep.push_back(out);
  }
  test::expect_input_error(
      [&] {
        (void)ros2::fit_recorded(
            {"/points", lidar_of(log)}, {sweep}, 0.1, ros2::Stamp::kStart, "some.mcap", "/points");
      },
      {"some.mcap", "/points: rings", "of some points"});
}

}  // namespace ros2_drivers_test
}  // namespace simuli

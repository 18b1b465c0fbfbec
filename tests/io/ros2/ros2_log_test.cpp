// The street as ROS 2 records it, by simuli itself and by the drivers of others, and back.
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
#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using ros2::PointField;
using test::expect_input_error;
using test::Scratch;

/// Coordinates are float32 (2e-6 m in the street), times of whole nanoseconds and float32 (1e-8 s).
constexpr double kStored_m = 1e-4;
constexpr double kStored_rad = 1e-5;
constexpr std::int64_t kStart_ns = 1'700'000'000'123'456'789;

Log street(const Scratch& scratch) {
  StreetOptions options;
  options.output = scratch / "street.log";
  options.frames = 3;
  options.image_width = 48;
  options.image_height = 27;
  options.lidar_columns = 180;
  return synth_street(options);
}

const Lidar& lidar_of(const Log& log) { return log.lidars.at(0).with_rows(); }

struct Point {
  Eigen::Vector3d p;
  double intensity, time_s;
  int row;
};

std::vector<Point> points_of(const Log& log, const SweepFrame& frame) {
  const Lidar& lidar = lidar_of(log);
  const Sweep sweep = read_sweep(log.folder / frame.file, lidar);
  std::vector<Point> points;
  for (std::size_t i = 0; i < sweep.range.size(); ++i) {
    if (sweep.range[i] == 0.0F) continue;
    const int row = static_cast<int>(i / static_cast<std::size_t>(lidar.columns));
    const double azimuth = sweep.rays.azimuth[i];
    points.push_back({lidar.origin(row, azimuth) +
                          double{sweep.range[i]} * Lidar::direction(azimuth, sweep.rays.elevation[i]),
                      sweep.intensity[i],
                      sweep.rays.time_fraction[i] * (frame.time_end_s - frame.time_start_s),
                      row});
  }
  return points;
}

/// As `simuli render -o x.mcap` writes it.
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

Ros2Options options_for(const Log& log, const fs::path& file, const fs::path& output) {
  Ros2Options options;
  options.recording = file;
  options.output = output;
  options.lidars = {{"/top/points", lidar_of(log)}};
  return options;
}

Log imported(const Ros2Options& options, Ros2Report& report) { return import_ros2(options, {}, report); }

void expect_same_sweeps(const Log& log, const Log& back) {
  ASSERT_EQ(back.sweeps.size(), log.sweeps.size());
  const Lidar& lidar = lidar_of(log);
  double range_off = 0.0, angle_off = 0.0, time_off = 0.0, intensity_off = 0.0;
  std::size_t returned = 0;
  for (std::size_t s = 0; s < log.sweeps.size(); ++s) {
    EXPECT_NEAR(back.sweeps[s].time_start_s - back.sweeps[0].time_start_s,
                log.sweeps[s].time_start_s - log.sweeps[0].time_start_s,
                1e-6);
    const Sweep a = read_sweep(log.folder / log.sweeps[s].file, lidar);
    const Sweep b = read_sweep(back.folder / back.sweeps[s].file, lidar_of(back));
    for (std::size_t i = 0; i < a.range.size(); ++i) {
      ASSERT_EQ(a.range[i] > 0.0F, b.range[i] > 0.0F) << "ray " << i;
      returned += a.range[i] > 0.0F ? 1 : 0;
      const auto off = [](float x, float y) { return std::abs(double{x} - double{y}); };
      range_off = std::max(range_off, off(a.range[i], b.range[i]));
      intensity_off = std::max(intensity_off, off(a.intensity[i], b.intensity[i]));
      const double turn =
          std::remainder(double{a.rays.azimuth[i]} - double{b.rays.azimuth[i]}, 2.0 * std::numbers::pi);
      angle_off = std::max({angle_off, std::abs(turn), off(a.rays.elevation[i], b.rays.elevation[i])});
      time_off = std::max(time_off, off(a.rays.time_fraction[i], b.rays.time_fraction[i]));
    }
  }
  EXPECT_GT(returned, 1000U);
  EXPECT_LT(range_off, kStored_m);
  EXPECT_LT(angle_off, kStored_rad);
  EXPECT_LT(time_off, 2e-5);         // of 0.1 s: 2e-6 s
  EXPECT_LT(intensity_off, 2.1e-3);  // half a step of 255
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

/// How a driver's clouds look.
struct Driver {
  const char* name;
  std::vector<PointField> fields;
  std::uint32_t step;
  bool is_ring_reversed;
  bool is_stamped_at_end;
};

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
       false},
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
  std::string data(cloud.row_step, '\0');  // and a last point without a return
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point& p = points[i];
    const double after_s = start_s + p.time_s - stamp_s;
    for (const PointField& field : driver.fields) {
      const std::size_t at = i * driver.step + field.offset;
      double value = 0.0;
      if (field.name == "x") value = p.p.x();
      if (field.name == "y") value = p.p.y();
      if (field.name == "z") value = p.p.z();
      if (field.name == "intensity") value = 255.0 * p.intensity;
      if (field.name == "reflectivity") value = 255.0 * p.intensity;
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

/// Clouds alone, the path as odometry of a frame that is fixed to the rig.
void record_by(const Driver& driver, const Log& log, const fs::path& file) {
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
      {{kStart_ns, "base_link"}, "/lidar_frame", log.lidars.at(0).rig_from_lidar},
      {{kStart_ns, "base_link"}, "imu", rig_from_imu}};
  mcap.add_message(tf, kStart_ns, ros2::to_cdr(fixed));
  for (const TimedPose& pose : log.world_from_rig.poses()) {
    const std::int64_t ns = kStart_ns + static_cast<std::int64_t>(std::llround(1e9 * pose.time_s));
    mcap.add_message(odometry,
                     static_cast<std::uint64_t>(ns),
                     ros2::to_cdr(ros2::OdometryMessage{{ns, "odom"}, "imu", pose.pose * rig_from_imu}));
  }
  for (const SweepFrame& frame : log.sweeps)
    mcap.add_message(clouds, kStart_ns, cloud_of(log, frame, driver));
  mcap.finish();
}

TEST(Ros2Log, DriversOfOthersAreUnderstood) {
  const Scratch scratch;
  const Log log = street(scratch);
  for (const Driver& driver : drivers()) {
    SCOPED_TRACE(driver.name);
    const fs::path file = scratch / fmt::format("{}.mcap", driver.name);
    record_by(driver, log, file);
    Ros2Options options = options_for(log, file, scratch / fmt::format("{}.log", driver.name));
    options.lidars[0].topic = "/points";
    // As if the table were of a sensor that was cabled otherwise: what the points say goes before it.
    options.lidars[0].table.azimuth_first = 1.0;
    options.lidars[0].table.spin = SpinDirection::kCounterClockwise;
    Ros2Report report;
    const Log back = imported(options, report);
    EXPECT_EQ(report.points.unplaced, 0U);
    EXPECT_EQ(lidar_of(back).spin, lidar_of(log).spin);
    // The turn's cut is found to a part of a column: rays are as measured, whichever column they are in.
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
          {"/top/points", "ring", "is it that sensor?"});
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

}  // namespace
}  // namespace simuli

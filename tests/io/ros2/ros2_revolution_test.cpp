// Tests that the spin found in points has priority over the table's first mode and the period of messages.
#include "io/import/ros2/ros2_revolution.hpp"

#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <random>
#include <string>

#include "host/core/base/angles.hpp"
#include "host/core/sensors/lidar_library.hpp"
#include "io/import/ros2/ros2_lidar.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace ros2_revolution_test {

using Sweeps = std::vector<std::vector<ros2::CloudPoint>>;

/// A LiDAR in its mode with the remaining part of its points.
struct Drive {
  Lidar lidar;
  bool has_times = true;
  double sector = 1.0;  // of a revolution
  int every = 1;        // only each N-th firing
  int together = 1;     // number of consecutive firings kept
  double gaps = 0.2;    // share of rays without a return, in runs
  double jitter = 0.0;  // of a point's azimuth and time, in columns
  bool has_rings = true;
};

Sweeps sweeps_of(const Drive& drive) {
  const Lidar& lidar = drive.lidar;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  Sweeps sweeps(2);
  for (auto& sweep : sweeps) {
    for (int c = 0; c < drive.sector * lidar.columns; ++c) {
      if (c % drive.every >= drive.together) continue;
      for (int r = 0; r < lidar.row_count(); ++r) {
        if (!fires(lidar, static_cast<std::size_t>(r * lidar.columns + c))) continue;
        if (std::sin(0.02 * (c + 31 * r)) > 1.0 - 2.0 * drive.gaps) continue;
        ros2::CloudPoint point;
        const double step = lidar.azimuth_span / lidar.columns;
        const double azimuth = lidar.azimuth(r, c) + drive.jitter * step * uniform(random);
        const double range = 20.0 + 5.0 * std::sin(0.01 * c + r);
        point.position = lidar.origin(r, azimuth) +
                         range * Lidar::direction(azimuth, lidar.rows[static_cast<std::size_t>(r)].elevation);
        if (drive.has_rings) point.ring = r;
        const double share = lidar.time_fraction(r, c) + drive.jitter * uniform(random) / lidar.columns;
        if (drive.has_times) point.time_s = share * lidar.sweep_s;
        sweep.push_back(point);
      }
    }
  }
  return sweeps;
}

/// Returns the LiDAR for `--lidar TOPIC=name`.
Ros2Lidar asked_for(const std::string& name) {
  const BuiltinLidar sensor = builtin_lidar_with_facts(name);
  Ros2Lidar requested{"/points", sensor.model, "", sensor.facts.modes, name.find('@') != std::string::npos};
  if (requested.is_mode_given) requested.modes = {sensor.facts.mode};
  return requested;
}

ros2::RecordedLidar found(const std::string& table, const Drive& drive, double apart_s) {
  return ros2::fit_recorded(
      asked_for(table), sweeps_of(drive), apart_s, ros2::Stamp::kStart, "drive.mcap", "/points");
}

TEST(Ros2Turn, ModeAndTurnAreFoundInThePoints) {
  struct Case {
    const char* recorded;
    double apart;  // period of messages in revolutions
    bool has_times = true;
    double sector = 1.0;
    double jitter = 0.0;
    bool has_rings = true;
  };
  for (const Case& c : {Case{"velodyne_vlp16@5", 1.0},
                        Case{"velodyne_vlp16@10", 1.0},
                        Case{"velodyne_vlp16@20", 1.0},
                        Case{"velodyne_vlp16@20", 1.0, true, 0.25},
                        Case{"velodyne_vlp16@10", 2.0},
                        Case{"velodyne_vlp16@20", 2.0},
                        Case{"velodyne_vlp16@20", 5.0, true, 1.0, 0.3},
                        Case{"velodyne_vlp16@20", 1.0, true, 1.0, 0.3, false},
                        Case{"velodyne_vlp16@10", 0.0},
                        Case{"velodyne_vlp16@10", 2.0, false},
                        Case{"velodyne_vlp16@20", 1.0, false},
                        Case{"velodyne_vlp16@20", 2.0, false, 1.0, 0.3},
                        Case{"velodyne_vlp16@5", 3.0, false},
                        Case{"hesai_xt32@20", 1.01},
                        Case{"hesai_pandar40p@10", 5.0},
                        Case{"hesai_pandar40p@20", 3.0, true, 1.0, 0.1},
                        Case{"ouster_os1_32_g@512x10", 1.0},
                        Case{"ouster_os1_32_g@1024x10", 1.0},
                        Case{"ouster_os1_32_g@2048x10", 1.0},
                        Case{"ouster_os1_32_g@512x20", 1.0},
                        Case{"ouster_os1_32_g@1024x20", 1.0},
                        Case{"ouster_os1_32_g@512x10", 1.0, false},
                        Case{"ouster_os1_32_g@2048x10", 1.0, false},
                        Case{"ouster_os1_32_g@1024x20", 1.0, false},
                        Case{"ouster_os1_32_g@1024x10", 2.0, true},
                        Case{"ouster_os1_32_g@2048x10", 5.0, false},
                        Case{"robosense_rs16@20", 10.0}}) {
    SCOPED_TRACE(fmt::format(
        "{}, messages {} turns apart, {} times", c.recorded, c.apart, c.has_times ? "with" : "without"));
    const std::string name = c.recorded;
    Drive drive{builtin_lidar(name)};
    drive.has_times = c.has_times;
    drive.sector = c.sector;
    drive.jitter = c.jitter;
    drive.has_rings = c.has_rings;
    const ros2::RecordedLidar lidar =
        found(name.substr(0, name.find('@')), drive, c.apart * drive.lidar.sweep_s);
    EXPECT_EQ(lidar.model.columns, drive.lidar.columns);
    EXPECT_NEAR(lidar.model.sweep_s, drive.lidar.sweep_s, 0.02 * drive.lidar.sweep_s);
    EXPECT_EQ(fmt::format("{}", fmt::join(lidar.notes, "\n")).find("a cloud of every") != std::string::npos,
              c.apart > 1.5);
    for (int r = 0; r < drive.lidar.row_count(); ++r) {
      const auto row = static_cast<std::size_t>(r);
      EXPECT_NEAR(lidar.model.rows[row].azimuth_offset, drive.lidar.rows[row].azimuth_offset, 1e-4);
    }
  }
}

TEST(Ros2Turn, RatesThatNoModeHasAreTaken) {
  Drive drive{in_mode(builtin_lidar("velodyne_vlp16"), {15.0, 1206})};
  for (const bool has_times : {true, false}) {
    drive.has_times = has_times;
    const ros2::RecordedLidar lidar = found("velodyne_vlp16", drive, 1.0 / 15.0);
    EXPECT_NEAR(lidar.model.columns, 1206, 2);
    EXPECT_NEAR(lidar.model.sweep_s, 1.0 / 15.0, 1e-4);
  }
  // Half of the firings, and the table of a file, which has no modes: these columns at this rate.
  drive = {builtin_lidar("hesai_xt16")};
  drive.every = 2;
  EXPECT_EQ(found("hesai_xt16", drive, 0.1).model.columns, 1000);
  Ros2Lidar requested{"/points", drive.lidar};
  drive = {in_mode(drive.lidar, {20.0, 1000})};
  const auto lidar =
      ros2::fit_recorded(requested, sweeps_of(drive), 0.05, ros2::Stamp::kUnknown, "drive.mcap", "/points");
  EXPECT_EQ(lidar.model.columns, 1000);
  EXPECT_NEAR(lidar.model.sweep_s, 0.05, 1e-4);
}

TEST(Ros2Turn, ThinnedCloudsKeepTheirTable) {
  Drive drive{builtin_lidar("velodyne_vlp16")};
  drive.every = 64;
  drive.gaps = 0.0;
  for (const bool has_times : {true, false}) {
    drive.has_times = has_times;
    const ros2::RecordedLidar lidar = found("velodyne_vlp16", drive, 0.2);
    EXPECT_EQ(lidar.model.columns, 1808);
    EXPECT_NEAR(lidar.model.sweep_s, 0.1, 1e-4);
    EXPECT_NE(fmt::format("{}", fmt::join(lidar.notes, "\n")).find("thinned"), std::string::npos);
  }
}

TEST(Ros2Turn, RowsThatFireLessOftenAreFound) {
  for (const char* name : {"hesai_ot128@10", "hesai_ot128@20", "hesai_qt128"}) {
    for (const bool is_in_table : {true, false}) {
      SCOPED_TRACE(name);
      Drive drive{builtin_lidar(name)};
      // Beams of either kind suffice.
      drive.lidar.rows.erase(drive.lidar.rows.begin() + 100, drive.lidar.rows.end());
      drive.lidar.rows.erase(drive.lidar.rows.begin(), drive.lidar.rows.begin() + 50);
      drive.sector = 0.3;
      Ros2Lidar requested = asked_for(name);
      requested.table = drive.lidar;
      // Without a pattern, and with a start half a column from the firings.
      if (!is_in_table) {
        for (LidarRow& row : requested.table.rows) row.every = 1, row.first = 0;
        requested.table.azimuth_first += 0.4 * kTurn / requested.table.columns;
      }
      const ros2::RecordedLidar lidar = ros2::fit_recorded(
          requested, sweeps_of(drive), drive.lidar.sweep_s, ros2::Stamp::kStart, "drive.mcap", "/points");
      EXPECT_EQ(lidar.model.columns, drive.lidar.columns);
      PointReport report;
      const auto sweep = sweeps_of(drive).front();
      const Sweep grid =
          grid_points(ros2::measured(sweep, lidar, "drive.mcap", "/points"), lidar.model, report);
      EXPECT_EQ(report.returned, sweep.size());
      EXPECT_EQ(report.unplaced + report.echoes, 0U);
      std::size_t fired = 0;
      for (int r = 0; r < drive.lidar.row_count(); ++r)
        fired += static_cast<std::size_t>(firings_of(drive.lidar, r));
      EXPECT_EQ(report.rays, fired);
      for (std::size_t ray = 0; ray < grid.range.size(); ++ray)
        ASSERT_TRUE(grid.range[ray] == 0.0F || fires(lidar.model, ray)) << ray;
    }
  }
  // The same sensor in its coarse resolution: half as many columns, in each of which all beams fire.
  Drive coarse{builtin_lidar("hesai_ot128")};
  coarse.lidar.rows.resize(50);
  coarse.sector = 0.3;
  Ros2Lidar requested = asked_for("hesai_ot128");
  requested.table = coarse.lidar;
  for (LidarRow& row : coarse.lidar.rows) row.every = 1, row.first = 0;
  coarse.lidar.columns /= 2;
  const ros2::RecordedLidar lidar = ros2::fit_recorded(
      requested, sweeps_of(coarse), coarse.lidar.sweep_s, ros2::Stamp::kStart, "drive.mcap", "/points");
  EXPECT_EQ(lidar.model.columns, coarse.lidar.columns);
  for (const LidarRow& row : lidar.model.rows) EXPECT_EQ(row.every, 1);

  // A beam reduced to every second point by a driver's filter is not such a beam if all are.
  Drive thinned{builtin_lidar("hesai_xt16")};
  thinned.every = 8;
  for (const LidarRow& row : found("hesai_xt16", thinned, 0.1).model.rows) EXPECT_EQ(row.every, 1);
  // Nor a beam reduced to two of sixteen columns.
  Drive pairs{builtin_lidar("hesai_ot128")};
  pairs.every = 16;
  pairs.together = 2;
  const ros2::RecordedLidar kept = found("hesai_ot128", pairs, 0.1);
  for (std::size_t r = 0; r < kept.model.rows.size(); ++r)
    EXPECT_EQ(kept.model.rows[r].every, pairs.lidar.rows[r].every) << r;
}

TEST(Ros2Turn, AnotherUnitIsTaken) {
  struct Case {
    const char* table;
    double offset_deg;
    bool has_rings;
  };
  for (const Case& c : {Case{"hesai_pandar64", 0.162, true},
                        Case{"hesai_pandar64", 0.162, false},
                        Case{"hesai_pandar64", -0.162, true},
                        Case{"hesai_pandar40p", 0.416, true},
                        Case{"hesai_pandar40p", 0.416, false},
                        Case{"hesai_xt32", 0.3, true},
                        Case{"velodyne_vlp16", -0.2, false},
                        Case{"ouster_os1_32_g", 0.0, true},
                        Case{"hesai_pandar64", 0.01, true}}) {
    SCOPED_TRACE(fmt::format("{} {}", c.table, c.offset_deg));
    Drive drive{builtin_lidar(c.table)};
    drive.has_rings = c.has_rings;
    drive.sector = 0.2;
    std::mt19937 random(3);
    std::normal_distribution<double> own(0.0, 0.005 * kDegree);
    for (LidarRow& row : drive.lidar.rows) row.elevation += c.offset_deg * kDegree + own(random);
    const ros2::RecordedLidar lidar = found(c.table, drive, drive.lidar.sweep_s);
    const bool is_other = std::abs(c.offset_deg) > 0.1;
    EXPECT_EQ(fmt::format("{}", fmt::join(lidar.notes, "\n")).find("another unit") != std::string::npos,
              is_other);
    for (int r = 0; is_other && r < drive.lidar.row_count(); ++r) {
      const auto row = static_cast<std::size_t>(r);
      EXPECT_NEAR(lidar.model.rows[row].elevation, drive.lidar.rows[row].elevation, 0.03 * kDegree);
    }
    PointReport report;
    const auto sweep = sweeps_of(drive).front();
    (void)grid_points(ros2::measured(sweep, lidar, "drive.mcap", "/points"), lidar.model, report);
    EXPECT_EQ(report.returned, sweep.size());  // none is an echo, none is on no beam
  }
}

TEST(Ros2Turn, WhatContradictsTheNamedModeIsRefused) {
  const auto refused =
      [](const char* requested, const Drive& drive, double apart_s, std::vector<std::string> words) {
        test::expect_input_error([&] { (void)found(requested, drive, apart_s); }, words);
      };
  refused("velodyne_vlp16@10",
          {builtin_lidar("velodyne_vlp16@20")},
          0.05,
          {"drive.mcap", "/points: turn", "0.05 s", "0.1 s", "velodyne_vlp16@10"});
  refused("ouster_os1_32_g@2048x10",
          {builtin_lidar("ouster_os1_32_g@1024x10")},
          0.1,
          {"/points: columns", "1024", "2048"});
  Drive other_unit{builtin_lidar("velodyne_vlp16")};
  other_unit.lidar.sweep_s = 1e-4;  // ms interpreted as s
  refused("velodyne_vlp16", other_unit, 0.1, {"/points: points' times", "no turn", "--point-time"});
}

TEST(Ros2Turn, RowsThatNeverReturnAreAnotherTable) {
  Drive drive{builtin_lidar("velodyne_vlp16")};
  for (const bool has_rings : {true, false}) {
    drive.has_rings = has_rings;
    test::expect_input_error([&] { (void)found("hesai_xt32", drive, 0.1); },
                             {"/points: rows", "16 of 32", "(0.000 degrees off in the mean, 16 of 16 rows)"});
  }
  // Every second ring, by its number, or a part of another sensor: reported.
  std::vector<std::vector<ros2::CloudPoint>> second = sweeps_of({builtin_lidar("hesai_xt32")});
  for (auto& sweep : second) std::erase_if(sweep, [](const ros2::CloudPoint& p) { return p.ring % 2 != 0; });
  Drive part{builtin_lidar("hesai_xt32")};
  part.lidar.rows.resize(20);
  for (const auto& [sweeps, reported] : {std::pair(second, "16 of 32 rows return nothing"),
                                         std::pair(sweeps_of(part), "12 of 32 rows return nothing")}) {
    const ros2::RecordedLidar lidar = ros2::fit_recorded(
        asked_for("hesai_xt32"), sweeps, 0.1, ros2::Stamp::kStart, "drive.mcap", "/points");
    EXPECT_NE(fmt::format("{}", fmt::join(lidar.notes, "\n")).find(reported), std::string::npos);
  }
}

}  // namespace ros2_revolution_test
}  // namespace simuli

// Tests properties of all built-in LiDARs in all modes.
#include "host/core/sensors/lidar_library.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <set>

#include "host/core/base/angles.hpp"
#include "tests/host/expect_error.hpp"

namespace simuli {
namespace {

constexpr double kTable = 1e-6;      // rad: tables are written in microradians
constexpr double kRounding = 1e-12;  // of formulas in double

std::vector<std::string> all_modes() {
  std::vector<std::string> names;
  for (const std::string& name : builtin_lidar_names()) {
    for (const LidarMode& mode : builtin_lidar_with_facts(name).facts.modes) {
      names.push_back(name + "@" + std::to_string(mode.columns) + "x" +
                      (mode.spin_hz == 9.66 ? "9.66" : std::to_string(static_cast<int>(mode.spin_hz))));
    }
  }
  return names;
}

TEST(LidarLibrary, EveryModelIsThereWithItsSource) {
  const std::vector<std::string> names = builtin_lidar_names();
  EXPECT_EQ(names.size(), 42U);
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size());
  for (const std::string& name : names) {
    const BuiltinLidar sensor = builtin_lidar_with_facts(name);
    EXPECT_EQ(sensor.model.name, name);
    EXPECT_FALSE(sensor.facts.source.empty()) << name;
    EXPECT_FALSE(sensor.facts.licence.empty()) << name;
    ASSERT_FALSE(sensor.facts.modes.empty()) << name;
    EXPECT_EQ(sensor.facts.mode.columns, sensor.facts.modes.front().columns) << name;
    EXPECT_EQ(sensor.model.columns, sensor.facts.mode.columns) << name;
  }
}

TEST(LidarLibrary, EveryModelIsValidAndSortedInEveryMode) {
  for (const std::string& name : all_modes()) {
    const Lidar lidar = builtin_lidar(name);
    EXPECT_NO_THROW(validate(lidar, name));
    for (std::size_t r = 1; r < lidar.rows.size(); ++r) {
      EXPECT_LT(lidar.rows[r].elevation, lidar.rows[r - 1].elevation) << name << " row " << r;
    }
    EXPECT_GE(lidar.range_min, 0.05) << name;
    EXPECT_LE(lidar.range_max, 300.0) << name;
  }
}

TEST(LidarLibrary, FiringsFollowTheSpinAndTheClock) {
  for (const std::string& name : all_modes()) {
    const BuiltinLidar sensor = builtin_lidar_with_facts(name);
    const Lidar& lidar = sensor.model;
    const double step = lidar.azimuth_span / lidar.columns;
    for (int row = 0; row < lidar.row_count(); ++row) {
      for (const int column : {1, lidar.columns / 2, lidar.columns - 1}) {
        EXPECT_NEAR((lidar.azimuth(row, column) - lidar.azimuth(row, column - 1)) * lidar.spin_sign(),
                    step,
                    kRounding)
            << name;
        EXPECT_GT(lidar.time_fraction(row, column), lidar.time_fraction(row, column - 1)) << name;
      }
      // Firing offsets stay within a few firing cycles of their column.
      EXPECT_NEAR(lidar.time_fraction(row, 0), 0.5 / lidar.columns, 2.5e-3) << name;
      EXPECT_NEAR(lidar.time_fraction(row, lidar.columns - 1), 1.0 - 0.5 / lidar.columns, 2.5e-3) << name;
    }
  }
}

TEST(LidarLibrary, FullTurnsCloseAndPartialOnesDoNot) {
  int partial = 0;
  for (const std::string& name : all_modes()) {
    const Lidar lidar = builtin_lidar(name);
    const double step = lidar.azimuth_span / lidar.columns;
    const double gap = std::remainder(
        (lidar.azimuth(0, 0) - lidar.azimuth(0, lidar.columns - 1)) * lidar.spin_sign(), 2.0 * kPi);
    const bool full = std::abs(lidar.azimuth_span - 2.0 * kPi) < kRounding;
    if (full) {
      EXPECT_NEAR(gap, step, 1e-9) << name;
    } else {
      ++partial;
      EXPECT_GT(std::abs(gap), 10.0 * step) << name;
    }
  }
  EXPECT_GE(partial, 1);  // the 120 degree sensor
}

TEST(LidarLibrary, ModesChooseColumnsAndRate) {
  EXPECT_EQ(builtin_lidar("hesai_xt32").columns, 2000);
  EXPECT_EQ(builtin_lidar("hesai_xt32@20").columns, 1000);
  EXPECT_EQ(builtin_lidar("hesai_xt32@20").name, "hesai_xt32@20");
  const BuiltinLidar fine = builtin_lidar_with_facts("ouster_os1_128@2048x10");
  EXPECT_EQ(fine.model.columns, 2048);
  EXPECT_EQ(fine.facts.mode.spin_hz, 10.0);
  for (const char* wrong :
       {"hesai_xt32@30", "hesai_xt32@", "hesai_xt32@x10", "hesai_xt32@2000x10x", "hesai_xt32@10 "}) {
    expect_error(ErrorKind::kUsage, "allowed 2000x10, 4000x5, 1000x20", [&] { (void)builtin_lidar(wrong); });
  }
}

TEST(LidarLibrary, UnknownNamesListCloseOnes) {
  expect_error(ErrorKind::kUsage, "found \"hesai_x32\", did you mean hesai_xt32", [] {
    (void)builtin_lidar("hesai_x32");
  });
  expect_error(ErrorKind::kUsage, "kitti_hdl64e", [] { (void)builtin_lidar("hdl65"); });
  expect_error(ErrorKind::kUsage, "velodyne_vlp16", [] { (void)builtin_lidar("vlp16"); });
  expect_error(ErrorKind::kUsage, "allowed those that \"simuli info sensors\" lists", [] {
    (void)builtin_lidar("zzzzzzzzzzzz");
  });
}

TEST(LidarLibrary, OusterBeamsStartOnACircleThatTurnsWithTheHead) {
  const Lidar lidar = builtin_lidar("ouster_os1_128");
  // The vendor's point: n (cos e, sin e) + d (cos(e + a) cos v, ...) with encoder angle e and the beam's
  // offset a.
  for (const int row : {0, 1, 64, 127}) {
    const double offset = lidar.rows[static_cast<std::size_t>(row)].azimuth_offset;
    for (const double head : {0.0, 1.0, -2.5}) {
      const Eigen::Vector3d origin = lidar.origin(row, head + offset);
      EXPECT_NEAR(origin.x(), 0.015806 * std::cos(head), kRounding);
      EXPECT_NEAR(origin.y(), 0.015806 * std::sin(head), kRounding);
      EXPECT_NEAR(origin.z(), 0.03618, kRounding);
    }
  }
}

TEST(LidarLibrary, TiltedVerticalOffsetsCrossTheAxisWhereTheCalibrationSays) {
  const Lidar lidar = builtin_lidar("velodyne_hdl64e_s2_sztaki");
  const LidarRow& top = lidar.rows.front();
  // An offset Vo across the beam makes the ray cross the spin axis at Vo / cos(v).
  const double crossing = top.vertical_offset - top.radial_offset * std::tan(top.elevation);
  EXPECT_NEAR(crossing, 0.2128 / std::cos(0.086744), 1e-9);
  EXPECT_NEAR(top.horizontal_offset, -0.026, kRounding);
}

TEST(LidarLibrary, LaterBeamsFireWhereTheHeadHasTurnedTo) {
  const Lidar slow = builtin_lidar("velodyne_vlp16@5");
  const Lidar fast = builtin_lidar("velodyne_vlp16@20");
  // The top beam is the last of the cycle: 15 x 2.304 us.
  EXPECT_NEAR(slow.rows[0].time_offset, 34.56e-6, 1e-9);
  EXPECT_NEAR(slow.rows[0].azimuth_offset, -2.0 * kPi * 5.0 * 34.56e-6, 1e-9);
  EXPECT_NEAR(fast.rows[0].azimuth_offset, -2.0 * kPi * 20.0 * 34.56e-6, 1e-9);
  EXPECT_EQ(fast.rows[15].azimuth_offset, 0.0);
}

TEST(LidarLibrary, DivergenceIsThatOfTheRoundBeamOfTheSameArea) {
  const BuiltinLidar sensor = builtin_lidar_with_facts("velodyne_vls128");
  EXPECT_NEAR(sensor.facts.divergence_horizontal, 3e-3, kTable);
  EXPECT_NEAR(sensor.facts.divergence_vertical, 1.5e-3, kTable);
  EXPECT_NEAR(sensor.model.beam_divergence, std::sqrt(4.5e-6), kTable);
  EXPECT_EQ(builtin_lidar("hesai_ot128").beam_divergence, 0.0);          // unknown
  EXPECT_EQ(builtin_lidar("ouster_os1_128").divergence_variance, 0.72);  // stated as FWHM
}

}  // namespace
}  // namespace simuli

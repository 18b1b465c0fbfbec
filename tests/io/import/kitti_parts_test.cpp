#include "io/import/kitti/kitti_parts.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "host/core/base/angles.hpp"
#include "tests/io/import/kitti_folder.hpp"
#include "tests/io/scratch.hpp"

namespace simuli::kitti {
namespace {

using test::expect_input_error;
using test::KittiFolder;
using test::Scratch;

TEST(KittiText, ReadsTimestampsToTheNanosecond) {
  const Scratch scratch;
  const auto file = scratch.file("t.txt",
                                 "2011-09-26 13:10:51.168593664\r\n\n1970-01-01 00:00:00\n"
                                 "1969-12-31 23:59:59.5\n2012-02-29 00:00:00.000000001\n");
  EXPECT_EQ(read_timestamps_ns(file),
            (std::vector<std::int64_t>{1317042651168593664, 0, -500000000, 1330473600000000001}));
  const auto lines = read_lines_ns(file);
  ASSERT_EQ(lines.size(), 5U);
  EXPECT_FALSE(lines[1].has_value());
  EXPECT_EQ(lines[2], 0);
}

TEST(KittiText, RefusesOtherTimestamps) {
  const Scratch scratch;
  for (const std::string line : {"2011-09-26",
                                 "2011-09-31 00:00:00",
                                 "2011-09-26 24:00:00",
                                 "2011-09-26 1:10:51",
                                 "2011-09-26 13:10:51.",
                                 "2011-09-26 13:10:51.1234567890",
                                 "2011-09-26 13:10:51,5",
                                 "2011-09-26 13:10:51.5 x",
                                 "2011-02-29 00:00:00"}) {
    const auto file = scratch.file("t.txt", "2011-09-26 13:10:51\n" + line + "\n");
    expect_input_error([&] { (void)read_timestamps_ns(file); },
                       {"t.txt: line 2: found \"" + line + "\"", "allowed YYYY-MM-DD HH:MM:SS"});
  }
}

TEST(KittiText, RefusesOtherNumbers) {
  const std::vector<double> numbers = parse_numbers(" 1 -2.5e+00\t3\n", 3, "c.txt", "T");
  EXPECT_EQ(numbers, (std::vector<double>{1.0, -2.5, 3.0}));
  expect_input_error([] { (void)parse_numbers("1 2", 3, "c.txt", "T"); },
                     {"c.txt: T: found 2 numbers, allowed 3 numbers"});
  expect_input_error([] { (void)parse_numbers("1 x 3", 3, "c.txt", "T"); }, {"c.txt: T: found \"x\""});
  expect_input_error([] { (void)parse_numbers("1 nan 3", 3, "c.txt", "T"); }, {"found \"nan\""});
}

TEST(KittiCalibration, PutsTheBaselineIntoTheTransform) {
  const Scratch scratch;
  const KittiFolder folder(scratch);
  const Calibration calibration = read_calibration(folder / "", true, {"image_02"});
  // P_rect_02 = 10 [1 | 0.05 0 0] with centre (6, 4), whose pixel (0, 0) has its centre at (0, 0).
  ASSERT_EQ(calibration.cameras.size(), 1U);
  const Camera& camera = calibration.cameras[0].model;
  EXPECT_EQ(camera.width, 12);
  EXPECT_EQ(camera.height, 8);
  EXPECT_EQ(camera.fx, 10.0);
  EXPECT_EQ(camera.cx, 6.5);
  EXPECT_EQ(camera.cy, 4.5);
  constexpr double kRounding = 1e-12;
  const Eigen::Vector3d ahead =
      calibration.cameras[0].rig_from_camera.inverse() * Eigen::Vector3d(10.0, 0.0, 0.0);
  EXPECT_LT((ahead - Eigen::Vector3d(0.05, -0.1, 9.7)).norm(), kRounding);
  EXPECT_LT((calibration.velo_from_imu.translation - Eigen::Vector3d(-0.8, 0.3, -0.8)).norm(), kRounding);
}

TEST(KittiPoses, EllipsoidMatchesKnownPlaces) {
  // The equator at Greenwich, facing east: x of the IMU is y of the earth's frame.
  const Pose equator = ecef_from_imu({});
  constexpr double kTolerance_m = 1e-6;
  EXPECT_LT((equator.translation - Eigen::Vector3d(6378137.0, 0.0, 0.0)).norm(), kTolerance_m);
  EXPECT_LT((equator.rotation * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_LT((equator.rotation * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitX()).norm(), 1e-12);
  // The pole: the semi-minor axis of WGS 84.
  EXPECT_NEAR(
      ecef_from_imu({kPi / 2, 0, 100.0, 0, 0, 0}).translation.z(), 6356752.314245 + 100.0, kTolerance_m);
}

TEST(KittiPoses, RollPitchYawTurnTheWayTheFormatSays) {
  const Eigen::Quaterniond ecef_from_enu = ecef_from_imu({}).rotation;
  const auto enu = [&](const GeodeticPose& pose, const Eigen::Vector3d& axis) {
    return Eigen::Vector3d(ecef_from_enu.conjugate() * (ecef_from_imu(pose).rotation * axis));
  };
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
  EXPECT_GT(enu({0, 0, 0, 0.1, 0, 0}, y).z(), 0.09);   // roll: left side up
  EXPECT_LT(enu({0, 0, 0, 0, 0.1, 0}, x).z(), -0.09);  // pitch: front down
  EXPECT_GT(enu({0, 0, 0, 0, 0, 0.1}, x).y(), 0.09);   // yaw: towards north
}

TEST(KittiColumns, AreUniqueIncreasingAndClose) {
  constexpr int kColumns = 2156;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<double> azimuths;
    const double phase = unit(random);
    for (int i = 0; i < kColumns; ++i) {
      if (unit(random) < 0.2) continue;  // no return
      // The encoder's rounding moves a firing by up to a quarter of a step.
      const double column = std::clamp(i + phase - 0.5 + 0.5 * (unit(random) - 0.5), -0.5, kColumns - 0.5);
      azimuths.push_back(kPi - (column + 0.5) / kColumns * 2.0 * kPi);
    }
    std::sort(azimuths.rbegin(), azimuths.rend());
    const std::vector<int> columns = assign_columns(azimuths, kColumns);
    ASSERT_EQ(columns.size(), azimuths.size());
    for (std::size_t i = 0; i < columns.size(); ++i) {
      ASSERT_GE(columns[i], 0);
      ASSERT_LT(columns[i], kColumns);
      if (i > 0) {
        ASSERT_GT(columns[i], columns[i - 1]);
      }
      const double ideal = (kPi - azimuths[i]) / (2.0 * kPi) * kColumns - 0.5;
      constexpr double kFarthest_columns = 1.5;  // half a column of rounding, one of making room
      ASSERT_NEAR(columns[i], ideal, kFarthest_columns);
    }
  }
}

TEST(KittiColumns, FillATurnThatIsFullOrBunched) {
  std::vector<double> same(5, 0.0);  // five echoes at one azimuth
  EXPECT_EQ(assign_columns(same, 11), (std::vector<int>{3, 4, 5, 6, 7}));
  EXPECT_EQ(assign_columns(std::vector<double>(3, kPi), 3), (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(assign_columns(std::vector<double>(2, -kPi), 9), (std::vector<int>{7, 8}));
  EXPECT_TRUE(assign_columns({}, 9).empty());
  expect_input_error([] { (void)assign_columns(std::vector<double>(4, 0.0), 3); }, {"found 4", "at most 3"});
}

TEST(KittiBeams, CountsPointsOfNoBeam) {
  const Lidar lidar = builtin_lidar("kitti_hdl64e");
  const Eigen::Vector3d on_beam =
      lidar.origin(20, 0.3) + 12.0 * Lidar::direction(0.3, lidar.rows[20].elevation);
  const BeamPoints beams = sort_into_beams({{on_beam, 0.5},
                                            {Eigen::Vector3d(1.0, 0.0, 5.0), 0.5},  // above all beams
                                            {Eigen::Vector3d::Zero(), 0.5}},        // no direction
                                           lidar);
  EXPECT_EQ(beams.unplaced, 2U);
  EXPECT_EQ(beams.ring_agrees, 1U);
  EXPECT_EQ(beams.rows[20].size(), 1U);
}

TEST(KittiSweep, GivesSilentRaysTheirPlaceInTheTurn) {
  Lidar lidar = builtin_lidar("kitti_hdl64e");
  lidar.columns = 8;
  lidar.azimuth_first = kPi * (1.0 - 1.0 / 8);
  BeamPoints beams;
  beams.rows.resize(64);
  // Row 3 returns at columns 2 and 5, a little off their even spacing.
  const double first = kPi - 2.4 / 8 * 2.0 * kPi;
  const double second = kPi - 5.6 / 8 * 2.0 * kPi;
  for (const double azimuth : {first, second}) {
    beams.rows[3].push_back({lidar.origin(3, azimuth) + 7.0 * Lidar::direction(azimuth, 0.015), 0.5});
  }
  const Sweep sweep = make_sweep(beams, lidar);
  constexpr double kFloat = 1e-6;
  const auto azimuth = [&](int column) {
    return sweep.rays.azimuth[static_cast<std::size_t>(3 * 8 + column)];
  };
  EXPECT_NEAR(azimuth(2), first, kFloat);
  EXPECT_NEAR(azimuth(5), second, kFloat);
  EXPECT_NEAR(azimuth(3), first + (second - first) / 3.0, kFloat);
  EXPECT_NEAR(azimuth(4), first + (second - first) * 2.0 / 3.0, kFloat);
  EXPECT_NEAR(azimuth(0), kPi + (first - kPi) * 0.5 / 2.5, kFloat);
  EXPECT_NEAR(azimuth(7), second + (-kPi - second) * 2.0 / 2.5, kFloat);
  for (std::size_t i = 0; i < lidar.ray_count(); ++i) {
    EXPECT_NEAR(sweep.rays.time_fraction[i], (kPi - sweep.rays.azimuth[i]) / (2.0 * kPi), kFloat);
    const bool returned = i == 3 * 8 + 2 || i == 3 * 8 + 5;
    EXPECT_NEAR(sweep.range[i], returned ? 7.0 : 0.0, 1e-5);
    EXPECT_EQ(sweep.intensity[i], returned ? 0.5F : 0.0F);
    EXPECT_NEAR(sweep.rays.elevation[i], returned ? 0.015 : lidar.rows[i / 8].elevation, kFloat);
  }
}

}  // namespace
}  // namespace simuli::kitti

#include "optim/calibration/beams/beams.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <random>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "io/import/kitti/kitti_parts.hpp"
#include "io/log/sensor_file.hpp"

namespace simuli::calibration {
namespace {

constexpr int kTicks = 4000;

/// Returns 16 beams from two columns of emitters, with irregular elevations like real sensors.
std::vector<LidarRow> true_rows() {
  std::vector<LidarRow> rows;
  for (int r = 0; r < 16; ++r) {
    LidarRow row;
    row.elevation = (3.0 - 1.3 * r - 0.2 * (r % 3)) * kDegree;
    row.vertical_offset = 0.15 - 0.004 * r;
    row.horizontal_offset = r % 2 == 0 ? 0.026 : -0.026;
    row.azimuth_offset = (r % 4 - 1.5) * 2.25 * kDegree + 0.013 * r * kDegree;
    rows.push_back(row);
  }
  return rows;
}

struct Firing {
  bool on_grid = true;    // azimuths are quantised by an encoder
  bool constant = false;  // all points are 8 m away
};

/// Returns sweeps of shuffled points, rounded to millimetres as recorders do; a fifth of the rays have no
/// return.
std::vector<RawSweep> fire(const Firing& how, int sweeps) {
  std::mt19937_64 dice(7);
  std::uniform_real_distribution<double> in(0.0, 1.0);
  const std::vector<LidarRow> rows = true_rows();
  std::vector<RawSweep> out;
  for (int s = 0; s < sweeps; ++s) {
    RawSweep& sweep = out.emplace_back();
    double tick = in(dice)*3.0;
    while (tick < kTicks) {
      tick += in(dice) < 0.857 ? 2.0 : 1.0;
      const double fired = how.on_grid ? std::round(tick) : tick + in(dice);
      for (const LidarRow& row : rows) {
        if (in(dice) < 0.2) continue;
        const double azimuth = fired * 2.0 * kPi / kTicks + row.azimuth_offset;
        const double range =
            how.constant ? 8.0 : 4.0 + 20.0 * std::pow(std::sin(1.5 * azimuth + 0.4 * s), 2.0) + in(dice);
        const double flat = range * std::cos(row.elevation);
        const Eigen::Vector3d p(flat * std::cos(azimuth) - row.horizontal_offset * std::sin(azimuth),
                                flat * std::sin(azimuth) + row.horizontal_offset * std::cos(azimuth),
                                range * std::sin(row.elevation) + row.vertical_offset);
        sweep.push_back((p * 1e3).array().round() * 1e-3);
      }
    }
    std::shuffle(sweep.begin(), sweep.end(), dice);
  }
  return out;
}

TEST(Beams, AreFoundInShuffledPoints) {
  const std::vector<LidarRow> truth = true_rows();
  const BeamTable table = find_beams(fire({}, 6));
  ASSERT_EQ(table.rows.size(), truth.size());
  EXPECT_LT(table.unplaced, table.points / 1000);
  EXPECT_EQ(table.encoder_ticks, kTicks);
  EXPECT_NEAR(table.columns, kTicks / 1.857, 15.0);  // the firings drawn vary by 0.4 %
  EXPECT_NEAR(table.returned_share, 0.8, 0.01);
  // Azimuth offsets are only determined relative to each other: compares differences.
  const double first = table.rows[0].row.azimuth_offset - truth[0].azimuth_offset;
  for (std::size_t r = 0; r < truth.size(); ++r) {
    const BeamEstimate& beam = table.rows[r];
    // Thousands of points at 4 to 24 m, rounded to 1 mm.
    EXPECT_NEAR(beam.row.elevation, truth[r].elevation, 0.02e-3) << r;
    EXPECT_NEAR(beam.row.vertical_offset, truth[r].vertical_offset, 1e-3) << r;
    EXPECT_NEAR(beam.row.horizontal_offset, truth[r].horizontal_offset, 0.5e-3) << r;
    EXPECT_NEAR(beam.row.azimuth_offset - truth[r].azimuth_offset, first, 0.005 * kDegree) << r;
    EXPECT_TRUE(beam.vertical_offset_known && beam.horizontal_offset_known && beam.azimuth_offset_known) << r;
    EXPECT_LT(beam.vertical_offset_sigma, 1e-3) << r;
  }
  EXPECT_TRUE(table.notes.empty()) << table.notes.front();
  const Lidar lidar = lidar_of(table, "made up", SpinDirection::kClockwise);
  EXPECT_NO_THROW(validate(lidar, "test"));
  EXPECT_EQ(lidar.row_count(), 16);
}

TEST(Beams, NearPointsAreHeldAgainstNone) {
  std::vector<RawSweep> sweeps = fire({}, 4);
  std::size_t near = 0;
  for (RawSweep& sweep : sweeps) {
    for (std::size_t i = 0; i < sweep.size(); i += 3, ++near) sweep[i] *= 0.4 / sweep[i].norm();
  }
  const BeamTable table = find_beams(sweeps);
  ASSERT_EQ(table.rows.size(), 16U);
  EXPECT_EQ(table.near, near);
  EXPECT_LT(table.unplaced, table.points / 1000);
  EXPECT_NEAR(table.rows[3].row.elevation, true_rows()[3].elevation, 0.05e-3);
  EXPECT_NEAR(lidar_of(table, "blind spot", SpinDirection::kClockwise).range_min, 0.4, 1e-6);
}

TEST(Beams, OneDistanceDeterminesNoOffsets) {
  // A round wall 8 m away: height over distance is constant, so offset and tilt are ambiguous.
  const BeamTable table = find_beams(fire({true, true}, 4));
  std::size_t unknown_heights = 0;
  std::size_t unknown_sides = 0;
  for (const BeamEstimate& beam : table.rows) {
    unknown_heights += beam.vertical_offset_known ? 0U : 1U;
    unknown_sides += beam.horizontal_offset_known ? 0U : 1U;
  }
  EXPECT_EQ(unknown_heights, table.rows.size());
  EXPECT_EQ(unknown_sides, table.rows.size());
  const auto says = [&](const char* what) {
    return std::any_of(table.notes.begin(), table.notes.end(), [&](const std::string& note) {
      return note.find(what) != std::string::npos;
    });
  };
  EXPECT_TRUE(says("vertical offset of 16 of 16 rows: not determined"));
  EXPECT_TRUE(says("horizontal offset of 16 of 16 rows: not determined"));
}

TEST(Beams, RowsAreInTheOrderOfTheSensor) {
  // A room: beams that only hit its floor, at similar distances, receive wrong offsets.
  RawSweep sweep;
  for (int i = 0; i < 400 * 16; ++i) {
    const double azimuth = i / 16 * 2.0 * kPi / 400.0, elevation = (15.0 - 2.0 * (i % 16)) * kDegree;
    const Eigen::Vector3d ahead = Lidar::direction(azimuth, elevation);
    const Eigen::Vector3d wall(
        ahead.x() > 0.0 ? 24.0 : -16.0, ahead.y() > 0.0 ? 12.0 : -12.0, ahead.z() > 0.0 ? 6.2 : -1.8);
    sweep.push_back(wall.cwiseQuotient(ahead).minCoeff() * ahead);
  }
  const BeamTable table = find_beams({sweep});
  ASSERT_EQ(table.rows.size(), 16U);
  for (std::size_t r = 0; r < table.rows.size(); ++r)
    EXPECT_NEAR(table.rows[r].row.elevation, (15.0 - 2.0 * static_cast<double>(r)) * kDegree, 0.05 * kDegree)
        << r;
}

TEST(Beams, AzimuthsOffAnyGridTellNoSideOffsets) {
  const BeamTable table = find_beams(fire({false, false}, 4));
  EXPECT_EQ(table.encoder_ticks, 0);
  ASSERT_EQ(table.rows.size(), 16U);
  EXPECT_NEAR(table.rows[3].row.vertical_offset, true_rows()[3].vertical_offset, 2e-3);
  ASSERT_FALSE(table.notes.empty());
  EXPECT_NE(table.notes.front().find("lie on no grid"), std::string::npos);
}

TEST(Beams, ACloudOfPointsIsRefused) {
  std::mt19937_64 dice(3);
  std::uniform_real_distribution<double> in(-20.0, 20.0);
  RawSweep sweep;
  for (int i = 0; i < 20000; ++i) sweep.emplace_back(in(dice), in(dice), in(dice));
  try {
    (void)find_beams({sweep});
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kNumeric);
    EXPECT_NE(std::string(error.what()).find("on no beam"), std::string::npos) << error.what();
  }
}

TEST(Beams, Kitti) {
  const char* const data = std::getenv("SIMULI_DATA");
  if (data == nullptr)
    GTEST_SKIP() << "not run: the beam table of KITTI's drive 0013, SIMULI_DATA is not set";
  const std::filesystem::path root = data;
  const std::filesystem::path drive =
      root / "kitti/2011_09_26/2011_09_26_drive_0013_sync/velodyne_points/data";
  std::vector<RawSweep> sweeps;
  for (const int i : {0, 8, 16, 24, 32, 40}) {
    RawSweep& sweep = sweeps.emplace_back();
    for (const kitti::Point& p : kitti::read_points(drive / fmt::format("{:010}.bin", i)))
      sweep.push_back(p.position);
  }
  const BeamTable table = find_beams(sweeps);
  const Lidar known = builtin_lidar("kitti_hdl64e");
  ASSERT_EQ(table.rows.size(), known.rows.size());
  for (std::size_t r = 0; r < known.rows.size(); ++r) {
    EXPECT_NEAR(table.rows[r].row.elevation, known.rows[r].elevation, 0.1e-3) << r;
    EXPECT_NEAR(table.rows[r].row.vertical_offset, known.rows[r].vertical_offset, 5e-3) << r;
    // Emitters of an HDL-64E are alternately 26 mm left and right of the axis.
    EXPECT_NEAR(table.rows[r].row.horizontal_offset, r % 2 == 0 ? -0.026 : 0.026, 1e-3) << r;
    EXPECT_TRUE(table.rows[r].azimuth_offset_known) << r;
  }
  EXPECT_EQ(table.encoder_ticks, 4000);
  EXPECT_NEAR(table.columns, 2155.0, 5.0);
}

}  // namespace
}  // namespace simuli::calibration

// Tests that each ray is found from a point on it.
#include "host/core/sensors/lidar_locate.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>

#include "host/core/base/angles.hpp"
#include "host/core/sensors/lidar_library.hpp"

namespace simuli {
namespace {

constexpr double kSteps = 1e-3;  // tolerance in beams or columns
constexpr double kRanges_m[] = {0.5, 3.0, 17.0, 100.0};

double row_step(const Lidar& lidar, int row) {
  const auto r = static_cast<std::size_t>(row);
  double step = kPi;
  if (r > 0) step = std::min(step, lidar.rows[r - 1].elevation - lidar.rows[r].elevation);
  if (r + 1 < lidar.rows.size()) step = std::min(step, lidar.rows[r].elevation - lidar.rows[r + 1].elevation);
  return step;
}

/// Returns the error of `hit` relative to (row, column) in steps; huge for another row.
double error_in_steps(const Lidar& lidar, const LidarHit& hit, int row, int column) {
  if (hit.row != row) return 1e9;
  double columns = std::abs(hit.column - column);
  if (lidar.azimuth_span > 2.0 * kPi - 1e-9) columns = std::abs(std::remainder(columns, lidar.columns));
  return std::max(columns, std::abs(hit.elevation_error) / row_step(lidar, row));
}

Eigen::Vector3d point_on_ray(const Lidar& lidar, int row, int column, double range) {
  const double azimuth = lidar.azimuth(row, column);
  return lidar.origin(row, azimuth) +
         range * Lidar::direction(azimuth, lidar.rows[static_cast<std::size_t>(row)].elevation);
}

std::vector<int> some_columns(const Lidar& lidar, int row) {
  return {0, (lidar.columns / 3 + 7 * row) % lidar.columns, lidar.columns - 1};
}

TEST(LidarLocate, EveryRowOfEveryTableAtRest) {
  double worst_of_all = 0.0;
  for (const std::string& name : builtin_lidar_names()) {
    const BuiltinLidar sensor = builtin_lidar_with_facts(name);
    const Lidar& lidar = sensor.model;
    double worst = 0.0;
    int shared = 0;
    for (int row = 0; row < lidar.row_count(); ++row) {
      for (const int column : some_columns(lidar, row)) {
        for (const double range : kRanges_m) {
          const Eigen::Vector3d p = point_on_ray(lidar, row, column, range);
          const auto own = locate_in_row(lidar, row, p);
          ASSERT_TRUE(own) << name << " row " << row << " column " << column;
          worst = std::max(worst, error_in_steps(lidar, *own, row, column));
          EXPECT_NEAR(own->range, range, 1e-9) << name;
          EXPECT_NEAR(own->time_fraction, lidar.time_fraction(row, column), 1e-9) << name;
          const auto best = locate(lidar, p);
          ASSERT_TRUE(best);
          if (best->row == row) continue;
          // Only a ray of another beam through the same point may be found instead.
          ++shared;
          EXPECT_LT(std::abs(best->elevation_error), 1e-9) << name << " row " << row << " at " << range;
        }
      }
    }
    EXPECT_LT(worst, kSteps) << name;
    EXPECT_EQ(shared, 0) << name;
    worst_of_all = std::max(worst_of_all, worst);
  }
  RecordProperty("worst_steps", std::to_string(worst_of_all));
}

Lidar one_row(double span, int columns) {
  Lidar lidar;
  lidar.name = "one";
  lidar.rows = {LidarRow{}};
  lidar.columns = columns;
  lidar.azimuth_first = kPi - span / columns / 2.0;
  lidar.azimuth_span = span;
  lidar.spin = SpinDirection::kClockwise;
  lidar.range_max = 100.0;
  return lidar;
}

TEST(LidarLocate, OutsideAPartialFieldOfViewIsNothing) {
  Lidar lidar = one_row(2.0, 200);
  lidar.azimuth_first = 1.0 - 0.005;  // 0.995 down to -0.995
  const auto at = [](double azimuth) { return Eigen::Vector3d(8.0 * Lidar::direction(azimuth, 0.0)); };
  EXPECT_TRUE(locate(lidar, at(0.999)));
  EXPECT_TRUE(locate(lidar, at(-0.999)));
  EXPECT_FALSE(locate(lidar, at(1.001)));
  EXPECT_FALSE(locate(lidar, at(-1.001)));
  EXPECT_FALSE(locate(lidar, at(kPi)));
  EXPECT_NEAR(locate(lidar, at(0.995))->column, 0.0, 1e-9);
  EXPECT_NEAR(locate(lidar, at(-0.995))->column, 199.0, 1e-9);
}

TEST(LidarLocate, PointInsideTheCircleOfBeamsHasNoRay) {
  Lidar lidar = one_row(2.0 * kPi, 360);
  lidar.rows[0].horizontal_offset = 0.05;
  EXPECT_FALSE(locate(lidar, {0.03, 0.0, 0.0}));
  EXPECT_FALSE(locate(lidar, {0.0, 0.0, 1.0}));
  EXPECT_TRUE(locate(lidar, {0.06, 0.0, 0.0}));
  lidar.rows[0].radial_offset = 0.05;
  EXPECT_FALSE(locate(lidar, {0.06, 0.0, 0.0}));
}

}  // namespace
}  // namespace simuli

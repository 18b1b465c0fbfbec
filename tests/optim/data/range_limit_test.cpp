#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>

#include "optim/data/sensor_learning.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace range_limit_test {

using test::Scratch;

constexpr int kColumns = 1000;

Lidar one_row() {
  Lidar lidar;
  lidar.name = "roof";
  lidar.rows = {{0.0}};
  lidar.columns = kColumns;
  lidar.azimuth_span = 2.0 * std::numbers::pi;
  lidar.range_min = 0.5;
  lidar.range_max = 120.0;
  return lidar;
}

/// Returns ten sweeps of `range(sweep, column)`.
Log log_of(const Scratch& folder, const std::function<double(int, int)>& range) {
  Log log;
  log.folder = folder.path();
  log.lidars.push_back({one_row(), Pose{}});
  for (int i = 0; i < 10; ++i) {
    Sweep sweep{nominal_rays(one_row()), {}, {}};
    for (int column = 0; column < kColumns; ++column) {
      sweep.range.push_back(static_cast<float>(range(i, column)));
      sweep.intensity.push_back(sweep.range.back() > 0.0F ? 0.5F : 0.0F);
    }
    const std::string name = fmt::format("{:02}.exr", i);
    write_sweep(folder / name, sweep);
    log.sweeps.push_back({"roof", name, 0.1 * i, 0.1 * (i + 1)});
  }
  return log;
}

TEST(RangeLimit, IsWhereReturnsEndAtOnce) {
  const Scratch folder;
  // 0.1 m apart up to 79.93 m; a held-out sweep has longer ranges.
  const Log log = log_of(folder, [](int sweep, int column) {
    return sweep == 4 ? 95.0 : std::fmod(0.1 * column, 79.93) + 0.01 * sweep;
  });
  const std::optional<double> limit = find_range_limit(log, log.lidars[0], {});
  ASSERT_TRUE(limit.has_value());
  EXPECT_NEAR(*limit, 80.0, 0.11);
  EXPECT_EQ(range_max(with_range_limit(log, {}).lidars[0].model), *limit);
}

TEST(RangeLimit, IsNoneWhereReturnsThinOut) {
  const Scratch folder;
  const Log log = log_of(folder, [](int sweep, int column) {
    return 80.0 - 3.0 * std::sqrt((column + 0.5) / kColumns) + 0.001 * sweep;  // 1 : 3 in the last two metres
  });
  EXPECT_FALSE(find_range_limit(log, log.lidars[0], {}).has_value());
  EXPECT_EQ(range_max(with_range_limit(log, {}).lidars[0].model), 120.0);
}

TEST(RangeLimit, IsNoneOfAFewReturns) {
  const Scratch folder;
  const Log log = log_of(folder, [](int, int column) { return column < 2 ? 30.0 : 0.0; });
  EXPECT_FALSE(find_range_limit(log, log.lidars[0], {}).has_value());
  const Log empty = log_of(folder, [](int, int) { return 0.0; });
  EXPECT_FALSE(find_range_limit(empty, empty.lidars[0], {}).has_value());
}

}  // namespace range_limit_test
}  // namespace simuli

// Tests the estimation of known range biases in sweeps of a street.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "io/synth/street.hpp"
#include "optim/base/metrics.hpp"
#include "optim/data/sensor_learning.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

using test::Scratch;

class RangeBiases : public testing::Test {
 protected:
  static Log street(const Scratch& folder) {
    StreetOptions options;
    options.output = folder / "street.log";
    options.frames = 15;
    options.image_width = 32;
    options.image_height = 18;
    options.lidar_columns = 900;
    options.moving_car = false;
    return synth_street(options);
  }
  /// Bias of beam r in m.
  static double bias_m(std::size_t row) { return 0.04 * std::sin(1.7 * static_cast<double>(row)); }
  static void add_biases(const Log& log) {
    const Lidar& lidar = log.lidars[0].with_rows();
    for (const SweepFrame& frame : log.sweeps) {
      Sweep sweep = read_sweep(log.folder / frame.file, lidar);
      for (std::size_t i = 0; i < sweep.range.size(); ++i) {
        if (sweep.range[i] > 0.0F) {
          sweep.range[i] += static_cast<float>(bias_m(i / static_cast<std::size_t>(lidar.columns)));
        }
      }
      write_sweep(log.folder / frame.file, sweep);
    }
  }
};

TEST_F(RangeBiases, AreFoundUpToTheirMedian) {
  const Scratch folder;
  const Log log = street(folder);
  add_biases(log);
  const std::vector<RangeBias> found = find_range_bias(log, log.lidars[0], {});
  const std::size_t rows = log.lidars[0].with_rows().rows.size();
  ASSERT_EQ(found.size(), rows);
  std::vector<double> truth;
  for (std::size_t row = 0; row < rows; ++row) {
    if (std::isfinite(found[row].sigma_m)) truth.push_back(bias_m(row));
  }
  ASSERT_GE(truth.size(), rows * 3 / 4);
  const double middle = median(truth);
  std::size_t sharp = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    if (!std::isfinite(found[row].sigma_m)) {
      EXPECT_EQ(found[row].bias_m, 0.0);
      continue;
    }
    // Beams that only measure house tops are less accurate, with larger standard deviations; the topmost has
    // no neighbour above.
    const double rim_m = row == 0 ? 0.01 : 0.0;
    EXPECT_NEAR(found[row].bias_m, bias_m(row) - middle, 0.004 + rim_m + 6.0 * found[row].sigma_m) << row;
    sharp += found[row].sigma_m < 0.0015 ? 1U : 0U;
  }
  EXPECT_GE(sharp, rows / 2);
  // Existing calibrations are kept: no bias is estimated twice.
  const Log corrected = with_range_bias(log, {});
  const auto counted = [](const LidarRow& row) { return row.range_bias != 0.0; };
  const std::vector<LidarRow>& corrected_rows = corrected.lidars[0].with_rows().rows;
  EXPECT_GE(std::count_if(corrected_rows.begin(), corrected_rows.end(), counted),
            static_cast<long>(rows / 2));
  const Log again = with_range_bias(corrected, {});
  for (std::size_t row = 0; row < rows; ++row) {
    EXPECT_EQ(again.lidars[0].with_rows().rows[row].range_bias, corrected_rows[row].range_bias);
  }
}

TEST_F(RangeBiases, AreNotSeenWhereThereAreNone) {
  const Scratch folder;
  const Log log = street(folder);
  for (const RangeBias& bias : find_range_bias(log, log.lidars[0], {})) {
    if (!std::isfinite(bias.sigma_m)) continue;
    EXPECT_LT(std::abs(bias.bias_m), 0.004 + 6.0 * bias.sigma_m);
  }
}

TEST_F(RangeBiases, NeedEightSweeps) {
  const Scratch folder;
  Log log = street(folder);
  log.sweeps.resize(8);  // two of them are held out
  EXPECT_TRUE(find_range_bias(log, log.lidars[0], {}).empty());
  EXPECT_EQ(with_range_bias(log, {}).lidars[0].with_rows().rows[0].range_bias, 0.0);
}

}  // namespace
}  // namespace simuli

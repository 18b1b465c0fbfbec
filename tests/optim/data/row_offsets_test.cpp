#include "optim/data/row_offsets.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "host/core/base/error.hpp"
#include "optim/train/trainer.hpp"
#include "tests/optim/small_street.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace row_offsets_test {

constexpr std::size_t kRows = 5;
constexpr std::size_t kColumns = 400;

/// All rays end 10 m away, half of them with half the opacity; beam r measures r x 1 cm more, with 2 cm of
/// noise.
void fill(Sweep& sweep, RayResults& seen) {
  sweep.range.resize(kRows * kColumns);
  sweep.rays.azimuth.resize(kRows * kColumns);
  seen.rays = sweep.range.size();
  seen.distance.resize(seen.rays);
  seen.transmittance.resize(seen.rays);
  for (std::size_t i = 0; i < seen.rays; ++i) {
    const float noise_m = 0.02F * (static_cast<float>(i % 5) - 2.0F) / 2.0F;
    sweep.range[i] = 10.0F + 0.01F * static_cast<float>(i / kColumns) + noise_m;
    sweep.rays.azimuth[i] = 2.0F * static_cast<float>(M_PI) * static_cast<float>(i % kColumns) / kColumns;
    seen.transmittance[i] = i % 2 == 0 ? 0.5F : 0.0F;
    seen.distance[i] = 10.0F * (1.0F - seen.transmittance[i]);
  }
}

TEST(RowOffsets, AreMediansLessTheirOwnMedian) {
  Sweep sweep;
  RayResults seen;
  fill(sweep, seen);
  for (std::size_t c = 0; c < kColumns; ++c) {
    if (c % 3 == 0) sweep.range[c] = 30.0F;            // another surface
    if (c % 3 == 1) sweep.range[kColumns + c] = 0.0F;  // no return
  }
  RowOffsets offsets(kRows);
  offsets.add(sweep, seen);
  offsets.add(sweep, seen);
  const std::vector<double> found = offsets.offsets();
  ASSERT_EQ(found.size(), kRows);
  for (std::size_t row = 0; row < kRows; ++row) {
    EXPECT_NEAR(found[row], 0.01 * (static_cast<double>(row) - 2.0), 1e-3) << row;
  }
  EXPECT_EQ(found[2], 0.0);
}

TEST(RowOffsets, OfOneSideAloneAreTheStreets) {
  Sweep sweep;
  RayResults seen;
  fill(sweep, seen);
  for (std::size_t c = 0; c < kColumns; ++c) sweep.range[4 * kColumns + c] -= c < 150 ? 0.0F : 0.08F;
  RowOffsets offsets(kRows);
  offsets.add(sweep, seen);
  EXPECT_NEAR(offsets.offsets()[4], -0.02 * (1.0 - 0.0146 * 0.0146 / (0.02 * 0.02)), 1e-3);
  EXPECT_NEAR(offsets.offsets()[0], -0.01, 1e-3);  // 1 cm below the median of the others
}

TEST(RowOffsets, AreNothingForRowsThatTellTooLittle) {
  Sweep sweep;
  RayResults seen;
  fill(sweep, seen);
  for (std::size_t c = RowOffsets::kFewestReturns - 1; c < kColumns; ++c)
    sweep.range[4 * kColumns + c] = 0.0F;
  RowOffsets offsets(kRows);
  EXPECT_EQ(offsets.offsets(), std::vector<double>(kRows, 0.0));
  offsets.add(sweep, seen);
  EXPECT_EQ(offsets.offsets()[4], 0.0);
  EXPECT_NEAR(offsets.offsets()[0], -0.015, 1e-3);  // of rows 0 to 3
  seen.rays -= 1;
  EXPECT_THROW(offsets.add(sweep, seen), Error);
}

using TrainedRanges = test::SmallStreet;

TEST_F(TrainedRanges, WrongOnesOfRowsAreTakenBack) {
  Log log = log_;  // with a false bias of 6 cm for every other beam
  Lidar& lidar = std::get<Lidar>(log.lidars[0].model);
  for (std::size_t row = 0; row < lidar.rows.size(); row += 2) lidar.rows[row].range_bias = 0.06;
  const auto spread_m = [](const LidarModel& model) {  // of neighbouring beams
    const std::vector<LidarRow>& rows = std::get<Lidar>(model).rows;
    double sum = 0.0;
    for (std::size_t row = 12; row + 1 < rows.size(); ++row) {  // beams on the road
      sum += std::abs(rows[row].range_bias - rows[row + 1].range_bias);
    }
    return sum / static_cast<double>(rows.size() - 13);
  };
  TrainingOptions o;
  o.train.iterations = 40;
  o.frames.image_scale = 1.0;
  o.train.lidar_every = 1;
  o.train.prune = {.weight = 1e-6, .first = 0, .times = 4, .last_share = 0.8};
  Trainer trainer(test::device(), log, initial_scene(), o);
  const TrainReport report = trainer.run();
  EXPECT_LT(spread_m(trainer.lidar(lidar.name)), 0.02);
  EXPECT_GT(report.row_ranges_m, 0.02);
  EXPECT_LT(report.row_ranges_m, 0.15);
  EXPECT_NEAR(spread_m(lidar), 0.06, 1e-9);

  o.train.prune.row_ranges = false;
  Trainer without(test::device(), log, initial_scene(), o);
  EXPECT_EQ(without.run().row_ranges_m, 0.0);
  EXPECT_NEAR(spread_m(without.lidar(lidar.name)), 0.06, 1e-9);
}

}  // namespace row_offsets_test
}  // namespace simuli

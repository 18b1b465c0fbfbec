#include "optim/train/schedule.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <vector>

#include "host/core/base/lru_cache.hpp"

namespace simuli {
namespace {

std::vector<std::size_t> epoch(FrameOrder& order, std::uint64_t index) {
  std::vector<std::size_t> frames;
  for (std::size_t i = 0; i < order.size(); ++i) frames.push_back(order.at(index * order.size() + i));
  return frames;
}

TEST(FrameOrder, EveryEpochIsAnotherPermutation) {
  const std::vector<std::size_t> frames = {0, 1, 2, 3, 5, 6, 7, 8, 10, 11, 12, 13};
  FrameOrder order(frames, 1, 1);
  const auto first = epoch(order, 0);
  const auto second = epoch(order, 1);
  for (auto e : {first, second}) {
    std::sort(e.begin(), e.end());
    EXPECT_EQ(e, frames);
  }
  EXPECT_NE(first, second);
  EXPECT_NE(first, frames);
}

TEST(FrameOrder, DrawsDependOnSeedStreamAndIterationAlone) {
  const std::vector<std::size_t> frames = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  FrameOrder order(frames, 1, 1), same(frames, 1, 1), other_seed(frames, 2, 1), other_stream(frames, 1, 2);
  const auto third = epoch(order, 3);
  (void)epoch(order, 0);
  EXPECT_EQ(epoch(order, 3), third);  // requested in another order
  EXPECT_EQ(epoch(same, 3), third);
  EXPECT_NE(epoch(other_seed, 3), third);
  EXPECT_NE(epoch(other_stream, 3), third);
}

TEST(FrameOrder, FirstPlacesAreShared) {
  // Each of 4 frames is first about equally often; 400 epochs, binomial: 100 +- 8.7, five sigma.
  FrameOrder order({0, 1, 2, 3}, 7, 1);
  std::vector<int> count(4, 0);
  for (std::uint64_t e = 0; e < 400; ++e) ++count[order.at(4 * e)];
  for (const int c : count) EXPECT_NEAR(c, 100, 44);
}

TEST(RowRates, EachGroupHasItsRate) {
  LearningRates rates;
  rates.mean_m = 1e-2;
  rates.mean_final_m = 1e-4;
  rates.final_share = 0.01;
  rates.last_share = 0.5;
  const std::vector<double> half = row_rates(rates, 1, 0.5);  // half-way on a logarithmic scale
  ASSERT_EQ(half.size(), static_cast<std::size_t>(param_rows(1)));
  EXPECT_NEAR(half[kMeanRow + 2], 1e-3, 1e-12);
  EXPECT_NEAR(half[kLogScaleRow], 0.1 * rates.log_scale, 1e-12);
  EXPECT_NEAR(half[kRotationRow + 3], 0.1 * rates.rotation, 1e-12);
  EXPECT_NEAR(half[kOpacityRow], 0.1 * rates.opacity, 1e-12);
  EXPECT_NEAR(half[kShRow + 2], 0.1 * rates.sh, 1e-12);
  EXPECT_NEAR(half[kShRow + 3], 0.1 * rates.sh_rest, 1e-12);
  EXPECT_EQ(row_rates(rates, 0, 0.0)[kMeanRow], 1e-2);
  EXPECT_EQ(row_rates(rates, 0, 0.0)[kOpacityRow], rates.opacity);
  // Over the last fifth they decrease to half of that.
  EXPECT_NEAR(row_rates(rates, 0, 0.8)[kOpacityRow], std::pow(0.01, 0.8) * rates.opacity, 1e-12);
  EXPECT_NEAR(row_rates(rates, 0, 0.9)[kOpacityRow], 0.75 * std::pow(0.01, 0.9) * rates.opacity, 1e-12);
  EXPECT_NEAR(row_rates(rates, 0, 1.0)[kMeanRow], 0.5e-4, 1e-15);
  EXPECT_NEAR(row_rates(rates, 0, 1.0)[kOpacityRow], 0.5 * 0.01 * rates.opacity, 1e-15);
}

TEST(RowRates, MoveScalesFasterInShortTrainings) {
  const LearningRates rates;
  const auto scale = [&rates](int iterations) {
    return paced(rates, iterations).log_scale / rates.log_scale;
  };
  EXPECT_EQ(scale(1500), 1.0);
  EXPECT_EQ(scale(3000), 1.0);
  EXPECT_NEAR(scale(300), std::cbrt(5.0), 1e-12);
  EXPECT_EQ(scale(20), 3.0);
  EXPECT_EQ(scale(0), 3.0);
  EXPECT_EQ(paced(rates, 20).mean_m, rates.mean_m);
  EXPECT_EQ(paced(rates, 20).opacity, rates.opacity);
}

TEST(RowEpsilons, AreOfColoursAndATenthOfThemOfMeans) {
  const std::vector<double> rows = row_epsilons(1, 1e-6);
  ASSERT_EQ(rows.size(), static_cast<std::size_t>(param_rows(1)));
  for (int row = 0; row < param_rows(1); ++row) {
    const double expected = row < kLogScaleRow ? 1e-7 : row < kShRow ? 0.0 : 1e-6;
    EXPECT_NEAR(rows[static_cast<std::size_t>(row)], expected, 1e-14) << row;
  }
}

TEST(LruCache, DropsWhatWasUsedLongestAgo) {
  LruCache<int> cache(100);
  int made = 0;
  const auto get = [&](std::size_t key, std::size_t bytes) {
    return cache.get(
        key,
        [&] {
          ++made;
          return static_cast<int>(key);
        },
        [bytes](int) { return bytes; });
  };
  const std::shared_ptr<const int> held = get(1, 40);
  get(2, 40);
  get(1, 40);  // now 2 is the oldest entry
  EXPECT_EQ(made, 2);
  get(3, 40);
  EXPECT_EQ(cache.used_bytes(), 80U);
  get(1, 40);
  EXPECT_EQ(made, 3);
  get(2, 40);
  EXPECT_EQ(made, 4);
  get(4, 101);  // larger than the budget: returned, not cached, and evicts no entry
  EXPECT_EQ(cache.size(), 2U);
  get(5, 100);
  EXPECT_EQ(cache.size(), 1U);
  EXPECT_EQ(*held, 1);  // evicted from the cache, kept alive by its holder
}

}  // namespace
}  // namespace simuli

// Radix sort against the standard library, in the shapes of CPUs and of GPUs.
#include "host/render/device/sort.hpp"

#include <algorithm>
#include <cstdint>
#include <gtest/gtest.h>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "tests/cl/support.hpp"

namespace simuli {
namespace {

using Words = std::vector<std::uint32_t>;

Words random_words(std::size_t count, double limit, std::uint64_t seed) {
  test::Random random(seed);
  Words words(count);
  for (std::uint32_t& w : words) w = static_cast<std::uint32_t>(random.uniform(0.0, limit));
  return words;
}

constexpr double kAll32Bits = 4294967296.0;
// Around one element per work-item, one chunk, one group, and far more.
constexpr std::size_t kSizes[] = {0, 1, 2, 15, 16, 17, 63, 64, 65, 255, 256, 257, 1000, 4095, 4097, 50'001};

class Sort : public testing::TestWithParam<std::size_t> {
 protected:
  Device device_ = Device::best();
};

TEST_P(Sort, IsThatOfTheStandardLibraryAndStable) {
  SortStage sort(device_, GetParam());
  Buffer<std::uint32_t> keys(device_, "keys"), values(device_, "values");
  for (const int bits : {1, 5, 11, 12, 22, 32}) {
    for (const std::size_t n : kSizes) {
      // Few distinct keys, so that ties abound; those of all 32 bits differ in their high bits as well.
      Words key_values = random_words(n, bits == 32 ? kAll32Bits : static_cast<double>(1U << bits), n + 1);
      for (std::size_t i = 0; i < n; i += 3) key_values[i] &= 0x40000003U;
      for (std::uint32_t& k : key_values) k &= static_cast<std::uint32_t>((std::uint64_t{1} << bits) - 1);
      Words order(n);
      std::iota(order.begin(), order.end(), 0U);
      keys.assign(std::span<const std::uint32_t>(key_values));
      values.assign(std::span<const std::uint32_t>(order));
      sort.run(keys, values, static_cast<std::uint32_t>(n), bits);
      std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return key_values[a] < key_values[b];
      });
      Words sorted(n);
      for (std::size_t i = 0; i < n; ++i) sorted[i] = key_values[order[i]];
      ASSERT_EQ(keys.download(), sorted) << n << " keys of " << bits << " bits";
      ASSERT_EQ(values.download(), order) << n << " keys of " << bits << " bits";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(WorkItems,
                         Sort,
                         testing::Values(std::size_t{1}, std::size_t{64}),
                         [](const auto& instance) {
                           return std::string(instance.param == 1 ? "cpu" : "gpu");
                         });

}  // namespace
}  // namespace simuli

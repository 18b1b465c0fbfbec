// Tests radix sort against the standard library, with the shapes of CPUs and of GPUs.
#include "host/device/render/device/sort.hpp"

#include <algorithm>
#include <cstdint>
#include <gtest/gtest.h>
#include <numeric>
#include <ostream>
#include <span>
#include <string>
#include <vector>

#include "tests/cl/support.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace sort_test {

using Words = std::vector<std::uint32_t>;

Words random_words(std::size_t count, double limit, std::uint64_t seed) {
  test::Random random(seed);
  Words words(count);
  for (std::uint32_t& w : words) w = static_cast<std::uint32_t>(random.uniform(0.0, limit));
  return words;
}

constexpr double kAll32Bits = 4294967296.0;
// Around one element per work-item and one chunk: few enough for an interpreter of kernels.
constexpr std::size_t kFew[] = {0, 1, 2, 15, 16, 17, 63, 64, 65, 255, 256, 257, 1000};
// Around one element per group's work-item, and many more.
constexpr std::size_t kMany[] = {1024, 4095, 4097, 50'001};

struct SortCase {
  std::size_t work_items;
  int bits;
};
void PrintTo(const SortCase& c, std::ostream* out) {
  *out << c.work_items << " work-items, " << c.bits << " bits";
}

class Sort : public testing::TestWithParam<SortCase> {
 protected:
  void expect_sorted(std::span<const std::size_t> sizes) {
    const auto& [work_items, bits] = GetParam();
    SortStage sort(device_, work_items);
    Buffer<std::uint32_t> keys(device_, "keys"), values(device_, "values");
    for (const std::size_t n : sizes) {
      // Few distinct keys, so that ties are frequent; keys of 32 bits also differ in their high bits.
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
  Device device_ = test::device();
};

TEST_P(Sort, OfFewIsThatOfTheStandardLibraryAndStable) { expect_sorted(kFew); }
TEST_P(Sort, OfManyIsThatOfTheStandardLibraryAndStable) { expect_sorted(kMany); }

std::vector<SortCase> cases() {
  std::vector<SortCase> all;
  for (const std::size_t work_items : {1U, 64U}) {
    for (const int bits : {1, 5, 11, 12, 22, 32}) all.push_back({work_items, bits});
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(WorkItems, Sort, testing::ValuesIn(cases()), [](const auto& pair) {
  return std::string(pair.param.work_items == 1 ? "cpu_" : "gpu_") + std::to_string(pair.param.bits) +
         "_bits";
});

}  // namespace sort_test
}  // namespace simuli

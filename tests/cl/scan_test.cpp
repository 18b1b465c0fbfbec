// Tests prefix sums against the standard library, with the shapes of CPUs and of GPUs.
#include "host/device/render/device/scan.hpp"

#include <cstdint>
#include <gtest/gtest.h>
#include <numeric>
#include <string>
#include <vector>

#include "tests/cl/support.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

using Words = std::vector<std::uint32_t>;

Words random_words(std::size_t count, double limit, std::uint64_t seed) {
  test::Random random(seed);
  Words words(count);
  for (std::uint32_t& w : words) w = static_cast<std::uint32_t>(random.uniform(0.0, limit));
  return words;
}

// Around one element per work-item, one chunk, one group, and many more.
constexpr std::size_t kSizes[] = {0, 1, 2, 15, 16, 17, 63, 64, 65, 255, 256, 257, 1000, 4095, 4097, 50'001};

class Scan : public testing::TestWithParam<std::size_t> {
 protected:
  Device device_ = test::device();
  ScanStage scan_{device_, GetParam()};
};

TEST_P(Scan, MatchesTheStandardLibrary) {
  for (const std::size_t n : kSizes) {
    const Words values = random_words(n, 1000.0, n);
    Words expected(n);
    std::exclusive_scan(values.begin(), values.end(), expected.begin(), 0U);
    // One element more than is summed, which must not change.
    Words padded = values;
    padded.push_back(77);
    Buffer<std::uint32_t> data(device_, "data", padded);
    const std::uint64_t total = scan_.run(data, static_cast<std::uint32_t>(n), true);
    EXPECT_EQ(total, std::accumulate(values.begin(), values.end(), std::uint64_t{0})) << n;
    Words found = data.download();
    EXPECT_EQ(found.back(), 77U) << n;
    found.pop_back();
    EXPECT_EQ(found, expected) << n;
  }
}

TEST_P(Scan, TotalsExceed32Bits) {
  const Words values(5, 0xffffffffU);
  Buffer<std::uint32_t> data(device_, "data", values);
  EXPECT_EQ(scan_.run(data, 5, true), std::uint64_t{5} * 0xffffffffU);
}

TEST_P(Scan, TellsTwoTotalsAtOnce) {
  for (const std::size_t n : kSizes) {
    const Words values = random_words(2 * n, 1000.0, n);
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(n);
    Words expected(n);
    std::exclusive_scan(values.begin(), middle, expected.begin(), 0U);
    Buffer<std::uint32_t> data(device_, "data", values);
    const auto [first, second] = scan_.run_two(data, static_cast<std::uint32_t>(n));
    EXPECT_EQ(first, std::accumulate(values.begin(), middle, 0U)) << n;
    EXPECT_EQ(second, std::accumulate(middle, values.end(), std::uint64_t{0})) << n;
    Words found = data.download();
    found.resize(n);
    EXPECT_EQ(found, expected) << n;
  }
  Buffer<std::uint32_t> data(device_, "data", Words{3, 4, 0xffffffffU, 0xffffffffU});
  EXPECT_EQ(scan_.run_two(data, 2), std::pair(7U, std::uint64_t{2} * 0xffffffffU));
}

TEST_P(Scan, TakesWhatIsTold) {
  Buffer<std::uint32_t> data(device_, "data", Words(50'001, 1));
  (void)scan_.run(data, 50'001, false);
  const auto reported = ScanBuffers(device_).bytes(ScanStage::sizes(device_, 50'001, GetParam()));
  for (const BufferBytes& buffer : reported)
    EXPECT_EQ(device_.memory_by_name().at(buffer.name).now, buffer.bytes) << buffer.name;
}

INSTANTIATE_TEST_SUITE_P(WorkItems,
                         Scan,
                         testing::Values(std::size_t{1}, std::size_t{64}),
                         [](const auto& pair) { return std::string(pair.param == 1 ? "cpu" : "gpu"); });

}  // namespace
}  // namespace simuli

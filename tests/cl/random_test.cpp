// Tests Philox against the authors' published vectors (Random123, kat_vectors) on the host and on the device.
#include "cl/math/random.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>
#include <vector>

#include "host/device/runtime/kernel.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace random_test {

struct Vector {
  std::array<std::uint32_t, 2> key;
  std::array<std::uint32_t, 4> counter, expected;
};

constexpr Vector kVectors[] = {{{0, 0}, {0, 0, 0, 0}, {0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}},
                               {{0xffffffff, 0xffffffff},
                                {0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff},
                                {0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}},
                               {{0xa4093822, 0x299f31d0},
                                {0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344},
                                {0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}}};

constexpr const char* kProbe = R"(
#include "math/random.h"
__kernel void words(__global const uint* in, __global uint* out) {
  const uint i = get_global_id(0);
  const Random4 r = philox(in[6 * i], in[6 * i + 1], in[6 * i + 2], in[6 * i + 3], in[6 * i + 4], in[6 * i + 5]);
  for (uint k = 0; k < 4; ++k) out[4 * i + k] = r.word[k];
}
__kernel void normals(const uint key, __global real* out) {
  const uint i = get_global_id(0);
  real three[3];
  normals_of(philox(key, 0, i, 0, 0, 0), three);
  for (uint k = 0; k < 3; ++k) out[3 * i + k] = three[k];
}
)";

TEST(Philox, PublishedVectorsOnHostAndDevice) {
  const Device& device = test::device();
  Kernel words(Program::from_text(device, "probe.cl", kProbe, BuildOptions()), "words");
  std::vector<std::uint32_t> in, expected;
  for (const Vector& v : kVectors) {
    in.insert(in.end(), v.key.begin(), v.key.end());
    in.insert(in.end(), v.counter.begin(), v.counter.end());
    expected.insert(expected.end(), v.expected.begin(), v.expected.end());
    const shared::Random4 r =
        shared::philox(v.key[0], v.key[1], v.counter[0], v.counter[1], v.counter[2], v.counter[3]);
    for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(r.word[k], v.expected[k]);
  }
  // Other inputs, for which host and device agree.
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const std::uint32_t words_in[6] = {i * 7919U, ~i, i, i * i, 3U * i, 0x80000000U + i};
    in.insert(in.end(), words_in, words_in + 6);
    const shared::Random4 r =
        shared::philox(words_in[0], words_in[1], words_in[2], words_in[3], words_in[4], words_in[5]);
    expected.insert(expected.end(), r.word, r.word + 4);
  }
  const Buffer<std::uint32_t> input(device, "in", in);
  Buffer<std::uint32_t> output(device, "out", expected.size());
  words.run(expected.size() / 4, 1, {{"in", input}, {"out", output}});
  EXPECT_EQ(output.download(), expected);
}

TEST(Philox, NormalsHaveTheMomentsOfTheNormalDistribution) {
  constexpr std::size_t kCount = 200'000;
  const Device& device = test::device();
  Kernel normals(Program::from_text(device, "probe.cl", kProbe, BuildOptions()), "normals");
  RealBuffer out(device, "out", Precision::kFloat, 3 * kCount);
  normals.run(kCount, 1, {{"key", 5U}, {"out", out}});
  const std::vector<double> x = out.download_double();
  double moment[5] = {};
  double mixed[3] = {};
  for (std::size_t i = 0; i < x.size(); ++i) {
    ASSERT_TRUE(std::isfinite(x[i]));
    for (int power = 1; power <= 4; ++power)
      moment[power] += std::pow(x[i], power) / static_cast<double>(x.size());
  }
  for (std::size_t i = 0; i < kCount; ++i) {
    mixed[0] += x[3 * i] * x[3 * i + 1] / kCount;
    mixed[1] += x[3 * i] * x[3 * i + 2] / kCount;
    mixed[2] += x[3 * i + 1] * x[3 * i + 2] / kCount;
  }
  // Five standard deviations of each estimate.
  const double n = static_cast<double>(x.size());
  EXPECT_NEAR(moment[1], 0.0, 5.0 / std::sqrt(n));
  EXPECT_NEAR(moment[2], 1.0, 5.0 * std::sqrt(2.0 / n));
  EXPECT_NEAR(moment[3], 0.0, 5.0 * std::sqrt(15.0 / n));
  EXPECT_NEAR(moment[4], 3.0, 5.0 * std::sqrt(96.0 / n));
  for (const double m : mixed) EXPECT_NEAR(m, 0.0, 5.0 / std::sqrt(static_cast<double>(kCount)));
}

}  // namespace random_test
}  // namespace simuli

// Tests the accuracy stated in cl/math/elementary.h over the stated domains.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <string>
#include <vector>

#include "host/device/runtime/kernel.hpp"
#include "tests/support/device.hpp"
#include "tests/support/scenes.hpp"

namespace simuli {
namespace math_test {

constexpr const char* kProbe = R"(
#include "math/elementary.h"
__kernel void probe(__global const real* a, __global const real* b, __global real* exp_out,
                    __global real* atan2_out, __global real* wrap_out, __global real* round_out,
                    __global real* sin_out, __global real* cos_out) {
  const uint i = get_global_id(0) * V;
  STV(exp_out + i, exp_lanes(LDV(a + i)));
  STV(atan2_out + i, atan2_lanes(LDV(b + i), LDV(a + i)));
  STV(wrap_out + i, wrap_lanes(LDV(a + i), TWO_PI_R));
  STV(round_out + i, round_lanes(LDV(a + i)));
  F sine, cosine;
  sincos_lanes(LDV(a + i), &sine, &cosine);
  STV(sin_out + i, sine);
  STV(cos_out + i, cosine);
}
)";

struct Probed {
  std::vector<float> exp, atan2, wrap, round, sin, cos;
};

Probed probe(int lanes, const std::vector<float>& a, const std::vector<float>& b) {
  const Device& device = test::device();
  BuildOptions options;
  options.define("V", lanes);
  Kernel kernel(Program::from_text(device, "probe.cl", kProbe, options), "probe");
  const auto buffer = [&](const char* name) { return RealBuffer(device, name, Precision::kFloat, a.size()); };
  RealBuffer in_a = buffer("a"), in_b = buffer("b");
  RealBuffer exps = buffer("exp"), angles = buffer("atan2"), wraps = buffer("wrap"), rounds = buffer("round");
  RealBuffer sines = buffer("sin"), cosines = buffer("cos");
  in_a.upload(std::span<const float>(a));
  in_b.upload(std::span<const float>(b));
  kernel.run(a.size() / static_cast<std::size_t>(lanes),
             1,
             {{"a", in_a},
              {"b", in_b},
              {"exp_out", exps},
              {"atan2_out", angles},
              {"wrap_out", wraps},
              {"round_out", rounds},
              {"sin_out", sines},
              {"cos_out", cosines}});
  return {exps.download_float(),
          angles.download_float(),
          wraps.download_float(),
          rounds.download_float(),
          sines.download_float(),
          cosines.download_float()};
}

class Elementary : public testing::TestWithParam<int> {};

TEST_P(Elementary, FloatFunctionsKeepTheirStatedBounds) {
  constexpr std::size_t kSamples = std::size_t{1} << 16U;
  constexpr double kExpRelative = 2.5e-7;
  constexpr double kAtan2_rad = 3.8e-7;
  constexpr double kTurn = 2.0 * std::numbers::pi;
  test::Random random(2);
  std::vector<float> a(kSamples), b(kSamples);
  for (std::size_t i = 0; i < kSamples; ++i) {
    a[i] = static_cast<float>(random.uniform(-86.9, 87.9));
    // All quadrants and slopes: magnitudes from 1e-3 to 1e3.
    b[i] = static_cast<float>(std::exp(random.uniform(-7, 7)) * (i % 2 == 0 ? 1.0 : -1.0));
  }
  a[0] = 0.0F;
  b[0] = 0.0F;
  const float edges[] = {0.0F, -86.999F, 87.999F, 1.0F, -1.0F, 1e-30F, 0.34657F, -0.34658F};
  std::copy(std::begin(edges), std::end(edges), a.begin() + 1);
  const Probed found = probe(GetParam(), a, b);

  double worst_exp = 0.0, worst_atan2 = 0.0, worst_wrap = 0.0, worst_sincos = 0.0;
  for (std::size_t i = 0; i < kSamples; ++i) {
    const double x = static_cast<double>(a[i]), y = static_cast<double>(b[i]);
    const double e = std::exp(x);
    worst_exp = std::max(worst_exp, std::abs(static_cast<double>(found.exp[i]) - e) / e);
    worst_atan2 = std::max(worst_atan2, std::abs(static_cast<double>(found.atan2[i]) - std::atan2(y, x)));
    // Modulo full turns: the result is the argument on the circle, within half a turn. A float turn has an
    // error of 2e-7 per subtracted turn, and a wrapped value has the rounding of its argument.
    const double wrapped = static_cast<double>(found.wrap[i]);
    ASSERT_LE(std::abs(wrapped), kTurn / 2.0 + 4e-6) << x;
    worst_wrap = std::max(worst_wrap, std::abs(std::remainder(wrapped - x, kTurn)));
    ASSERT_EQ(found.round[i], std::nearbyint(a[i])) << x;
    worst_sincos = std::max(worst_sincos, std::abs(static_cast<double>(found.sin[i]) - std::sin(x)));
    worst_sincos = std::max(worst_sincos, std::abs(static_cast<double>(found.cos[i]) - std::cos(x)));
  }
  EXPECT_LE(worst_exp, kExpRelative);
  EXPECT_LE(worst_atan2, kAtan2_rad);
  EXPECT_LE(worst_sincos, 2e-7);
  EXPECT_LE(worst_wrap, 14.5 * 2e-7 + 5e-7);
  EXPECT_EQ(found.atan2[0], 0.0F);  // atan2(0, 0)
}

TEST_P(Elementary, WrappedAnglesAreExactWithinOneTurn) {
  // Azimuths are differences of two angles in [-pi, pi].
  constexpr std::size_t kSamples = 4096;
  constexpr double kTurn = 2.0 * std::numbers::pi;
  test::Random random(3);
  std::vector<float> a(kSamples), b(kSamples, 1.0F);
  for (float& x : a) x = static_cast<float>(random.uniform(-kTurn, kTurn));
  const Probed found = probe(GetParam(), a, b);
  for (std::size_t i = 0; i < kSamples; ++i) {
    const double expected = std::remainder(static_cast<double>(a[i]), kTurn);
    const double error = static_cast<double>(found.wrap[i]) - expected;
    ASSERT_LE(std::abs(std::remainder(error, kTurn)), 4e-7) << a[i];
  }
}

INSTANTIATE_TEST_SUITE_P(Lanes, Elementary, testing::Values(1, 16), [](const auto& pair) {
  return std::string(pair.param == 1 ? "scalar" : "vector16");
});

TEST(DeviceMath, SumsOfSixteenVectorsAreThoseOfEach) {
  constexpr const char* kSums = R"(
#include "math/lanes.h"
__kernel void sums(__global const real* values, __global real* each, __global real* together) {
  F v[16];
  for (int k = 0; k < 16; ++k) v[k] = LDV(values + 16 * k);
  for (int k = 0; k < 16; ++k) each[k] = HSUM(v[k]);
  STV(together, hsum16_each(v));
}
)";
  const Device& device = test::device();
  BuildOptions options;
  options.define("V", 16);
  Kernel kernel(Program::from_text(device, "sums.cl", kSums, options), "sums");
  test::Random random(5);
  std::vector<float> values(256);
  for (float& value : values) value = static_cast<float>(random.normal());
  RealBuffer in(device, "values", Precision::kFloat, 256);
  RealBuffer each(device, "each", Precision::kFloat, 16), together(device, "together", Precision::kFloat, 16);
  in.upload(std::span<const float>(values));
  kernel.run(1, 1, {{"values", in}, {"each", each}, {"together", together}});
  EXPECT_EQ(together.download_float(), each.download_float());
  const std::vector<float> sums = each.download_float();
  for (std::size_t k = 0; k < 16; ++k) {
    double sum = 0.0;
    for (std::size_t lane = 0; lane < 16; ++lane) sum += values[16 * k + lane];
    EXPECT_NEAR(sums[k], sum, 1e-5);
  }
}

}  // namespace math_test
}  // namespace simuli

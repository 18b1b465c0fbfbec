// Tests Adam against the textbook (Kingma and Ba, algorithm 1) in double.
#include "host/device/render/train/adam.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <span>
#include <vector>

#include "host/core/scene/gaussians.hpp"
#include "tests/cl/support.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

/// Algorithm 1 for one parameter at a time.
struct Textbook {
  std::vector<double> params, first, second;
  int steps = 0;

  /// Returns the step of parameter i for gradient g and rate 1.
  double step_of(std::size_t i, double g, double epsilon) {
    constexpr double kBeta1 = 0.7, kBeta2 = 0.999;
    first[i] = kBeta1 * first[i] + (1.0 - kBeta1) * g;
    second[i] = kBeta2 * second[i] + (1.0 - kBeta2) * g * g;
    const double m = first[i] / (1.0 - std::pow(kBeta1, steps));
    const double v = second[i] / (1.0 - std::pow(kBeta2, steps));
    return m / (std::sqrt(v) + epsilon);
  }

  /// Steps parameters by rows, starting with row `from`.
  void step(const std::vector<double>& gradients,
            const AdamRows& rows,
            std::size_t stride,
            std::size_t from = 0) {
    ++steps;
    first.resize(params.size(), 0.0);
    second.resize(params.size(), 0.0);
    for (std::size_t i = from * stride; i < params.size(); ++i) {
      const double g = std::isfinite(gradients[i]) ? gradients[i] : 0.0;
      const double epsilon = rows.epsilon.empty() ? kAdamEpsilon : rows.epsilon[i / stride];
      params[i] -= rows.rate[i / stride] * step_of(i, g, epsilon);
    }
  }

  /// Steps a set: means along their particle's axes, in proportion to its standard deviations.
  void step_set(const std::vector<double>& gradients, const AdamRows& rows, std::size_t stride) {
    const std::vector<double> before = params;
    step(gradients, rows, stride, kLogScaleRow);
    for (std::size_t i = 0; i < stride; ++i) {
      const auto of = [&](const std::vector<double>& matrix, int row) {
        return matrix[static_cast<std::size_t>(row) * stride + i];
      };
      const Eigen::Quaterniond turn(of(before, kRotationRow),
                                    of(before, kRotationRow + 1),
                                    of(before, kRotationRow + 2),
                                    of(before, kRotationRow + 3));
      if (!(turn.norm() > 0.0)) continue;  // padding
      const Eigen::Matrix3d axes = turn.normalized().toRotationMatrix();
      Eigen::Vector3d gradient, deviation, own;
      for (int k = 0; k < 3; ++k) {
        gradient[k] = of(gradients, k);
        deviation[k] = std::exp(of(before, kLogScaleRow + k));
      }
      if (!gradient.allFinite()) gradient.setZero();
      gradient = axes.transpose() * gradient;
      for (int k = 0; k < 3; ++k) {
        const std::size_t row = static_cast<std::size_t>(k);
        own[k] = rows.rate[row] * deviation[k] / std::sqrt(std::cbrt(deviation.prod()) * 0.02) *
                 step_of(row * stride + i, gradient[k], rows.epsilon[row] / deviation[k]);
      }
      const Eigen::Vector3d moved = axes * own;
      for (int k = 0; k < 3; ++k) params[static_cast<std::size_t>(k) * stride + i] -= moved[k];
    }
  }
};

class Adam : public testing::TestWithParam<Precision> {};

TEST_P(Adam, FollowsTheTextbookAndRejectsWhatIsNotFinite) {
  const Device& device = test::device();
  if (GetParam() == Precision::kDouble) SIMULI_NEEDS_DOUBLE(device);
  constexpr std::uint32_t kSteps = 20;
  const GaussianSet set = test::set_for(test::kCameraRolling, {.count = 37}, 8);
  ParticleBuffers particles(device, set, GetParam());
  AdamStage adam(device, particles);
  const std::vector<double> start = particles.params.download_double();
  Textbook expected{start, {}, {}};
  AdamRows rows;
  for (int row = 0; row < param_rows(set.sh_degree); ++row) {
    rows.rate.push_back(1e-3 * (row % 4));
    rows.epsilon.push_back(row % 3 == 0 ? 0.1 : 1e-15);  // gradients are of 1e-5 to 20
  }

  // NaN and infinite gradients move nothing and do not change the moments.
  const std::size_t stride = particles.stride;
  const std::size_t bad[] = {stride * 1 + 3, stride * 5 + 35, stride * 7 + 16};
  // Particles culled in every frame do not move, whatever their gradients contain.
  const std::vector<std::uint32_t> culled = {0, 17, 36};
  std::vector<std::uint32_t> visible(static_cast<std::size_t>(set.size()), 1U);
  for (const std::uint32_t particle : culled) visible[particle] = 0xffffffffU;
  const Buffer<std::uint32_t> keys(device, "keys", visible);
  test::Random random(1);
  RealBuffer grads(device, "gradients", GetParam());
  std::vector<double> g(start.size());
  for (std::uint32_t step = 0; step < kSteps; ++step) {
    for (double& value : g) {
      // Representable in float: both builds and the textbook use the same numbers.
      value = static_cast<double>(static_cast<float>(random.normal() * std::exp(random.uniform(-12, 3))));
    }
    g[bad[0]] = std::numeric_limits<double>::quiet_NaN();
    g[bad[1]] = std::numeric_limits<double>::infinity();
    g[bad[2]] = -std::numeric_limits<double>::infinity();
    grads.assign(std::span<const double>(g));
    adam.run(particles, grads, keys, rows);
    for (std::size_t i = 0; i < g.size(); ++i) {
      // Padding is treated as culled.
      if (i % stride >= visible.size() || visible[i % stride] != 1U) g[i] = 0.0;
    }
    expected.step_set(g, rows, stride);
  }
  const std::vector<double> found = particles.params.download_double();
  // Twenty sums, each rounded relative to the parameter, and the rounding of the steps.
  const double rounding = 20.0 * (GetParam() == Precision::kDouble ? 1.2e-16 : 6e-8);
  double moved = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    ASSERT_NEAR(found[i], expected.params[i], rounding * (1.0 + std::abs(start[i]))) << i;
    moved = std::max(moved, std::abs(found[i] - start[i]));
  }
  EXPECT_GT(moved, 1e-3);
  for (const std::size_t i : bad) EXPECT_EQ(found[i], start[i]);
  EXPECT_EQ(adam.rejected(), 3U * kSteps);
}

TEST_P(Adam, DenseStepsMoveTheirPartAlone) {
  const Device& device = test::device();
  if (GetParam() == Precision::kDouble) SIMULI_NEEDS_DOUBLE(device);
  constexpr std::size_t kPart = 48, kParts = 3;
  constexpr double kRate = 0.01;
  test::Random random(2);
  std::vector<double> start(kParts * kPart);
  for (double& value : start) value = static_cast<double>(static_cast<float>(random.normal()));
  RealBuffer params(device, "parameters", GetParam());
  params.assign(std::span<const double>(start));
  RealBuffer grads(device, "gradients", GetParam(), kPart);
  AdamStage adam(device, GetParam(), start.size());
  // The last part has three own steps, the first part one, the middle part none.
  Textbook last{{start.end() - kPart, start.end()}, {}, {}};
  Textbook first{{start.begin(), start.begin() + kPart}, {}, {}};
  const auto step = [&](Textbook& book, std::size_t at, std::uint64_t number) {
    std::vector<double> g(kPart);
    for (double& value : g) value = static_cast<double>(static_cast<float>(random.normal()));
    grads.assign(std::span<const double>(g));
    adam.run_dense(params, grads, at, kPart, kRate, number);
    book.step(g, {{kRate}}, kPart);
  };
  step(last, 2 * kPart, 1);
  step(last, 2 * kPart, 2);
  step(first, 0, 1);
  step(last, 2 * kPart, 3);
  const std::vector<double> found = params.download_double();
  const double rounding = 3.0 * (GetParam() == Precision::kDouble ? 1.2e-16 : 6e-8);
  for (std::size_t i = 0; i < kPart; ++i) {
    EXPECT_NEAR(found[i], first.params[i], rounding * (1.0 + std::abs(start[i])));
    EXPECT_EQ(found[kPart + i], start[kPart + i]);
    EXPECT_NEAR(found[2 * kPart + i], last.params[i], rounding * (1.0 + std::abs(start[2 * kPart + i])));
    EXPECT_GT(std::abs(found[2 * kPart + i] - start[2 * kPart + i]), 1e-4);
  }
  EXPECT_EQ(adam.rejected(), 0U);
}

INSTANTIATE_TEST_SUITE_P(All,
                         Adam,
                         testing::Values(Precision::kFloat, Precision::kDouble),
                         [](const auto& pair) {
                           return pair.param == Precision::kFloat ? "in_float" : "in_double";
                         });

}  // namespace
}  // namespace simuli

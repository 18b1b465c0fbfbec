// Scale, opacity and entropy terms against quotients of their definition.
#include "host/render/train/regularize.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <span>
#include <vector>

#include "tests/cl/support.hpp"
#include "tests/render/gradient/gradient_check.hpp"

namespace simuli {
namespace {

class Regularize : public testing::TestWithParam<Precision> {};

double sigma(double logit) { return 1.0 / (1.0 + std::exp(-logit)); }

TEST_P(Regularize, GradientsMatchQuotientsAndWrongOnesDoNot) {
  const Device device = Device::best();
  if (GetParam() == Precision::kDouble) SIMULI_NEEDS_DOUBLE(device);
  const double tolerance = GetParam() == Precision::kDouble ? 1e-6 : 1e-5;
  GaussianSet set = test::set_for(test::kLidarMoving, {.count = 37, .scale_max = 3.0}, 12);
  set.opacity_logit()(3) = 12.0F;
  set.opacity_logit()(4) = -12.0F;
  const ParticleBuffers particles(device, set, GetParam());
  const std::size_t stride = particles.stride;
  std::vector<double> params = particles.params.download_double();
  constexpr RegularizeScale kScale{0.7, 0.4, 1.3};
  const auto loss = [&] {
    double sum = 0.0;
    for (std::size_t i = 0; i < particles.count; ++i) {
      for (std::size_t row = 0; row < 3; ++row) {
        sum += kScale.scale * std::exp(params[(kLogScaleRow + row) * stride + i]);
      }
      const double s = sigma(params[kOpacityRow * stride + i]);
      // 1 - sigma from the other side: it does not cancel.
      const double rest = sigma(-params[kOpacityRow * stride + i]);
      sum += kScale.opacity * s - kScale.entropy * (s * std::log(s) + rest * std::log(rest));
    }
    return sum;
  };
  RealBuffer grads(device, "gradients", GetParam(), params.size());
  grads.fill(2.0);  // the stage adds
  RegularizeStage(device, GetParam()).run(particles, kScale, grads);
  std::vector<double> gradient = grads.download_double();
  for (double& g : gradient) g -= 2.0;
  for (const auto& [first_row, rows] : {std::pair{kLogScaleRow, 3}, std::pair{kOpacityRow, 1}}) {
    std::vector<std::size_t> entries;
    for (int row = first_row; row < first_row + rows; ++row) {
      for (std::size_t i = 0; i < particles.count; ++i) {
        entries.push_back(static_cast<std::size_t>(row) * stride + i);
      }
    }
    const test::Quotients found = test::compare_quotients(gradient, entries, [&](std::size_t i, double by) {
      const double before = params[i];
      params[i] = before + by;
      const double result = loss();
      params[i] = before;
      return result;
    });
    EXPECT_LE(found.error, tolerance);
    EXPECT_GT(found.error_if_scaled, tolerance);
  }
  for (std::size_t i = 0; i < particles.count; ++i) {
    EXPECT_EQ(gradient[i], 0.0);
    EXPECT_EQ(gradient[kShRow * stride + i], 0.0);
  }
}

INSTANTIATE_TEST_SUITE_P(All,
                         Regularize,
                         testing::Values(Precision::kFloat, Precision::kDouble),
                         [](const auto& instance) {
                           return instance.param == Precision::kFloat ? "in_float" : "in_double";
                         });

}  // namespace
}  // namespace simuli

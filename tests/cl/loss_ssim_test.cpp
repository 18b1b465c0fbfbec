// Tests structural similarity against a window-by-window loop in double, and its gradient against difference
// quotients.
#include <cmath>
#include <gtest/gtest.h>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "host/device/render/train/loss_stages.hpp"
#include "tests/cl/support.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace loss_ssim_test {

// Variances of values near 1 are differences of numbers near 1, with C2 = 9e-4: 24 bits give an error of 1e-4
// of one window's SSIM, and less for the mean.
constexpr double kFloatMeanTolerance = 2e-5;
constexpr double kDoubleMeanTolerance = 1e-12;
constexpr double kGradientTolerance = 1e-6;

/// A picture in slot order; some pixels have no ray or are masked.
struct Picture {
  Picture(int w, int h, bool masked) : width(w), height(h) {
    frame.tiles_x = static_cast<std::uint32_t>((w + 15) / 16);
    frame.tiles_y = static_cast<std::uint32_t>((h + 15) / 16);
    frame.slots = frame.tiles_x * frame.tiles_y * SIM_TILE_RAYS;
    const std::size_t s = frame.slots;
    test::Random random(23);
    picture.assign(3 * s, 0.5);
    truth.assign(3 * s, 0.25);
    ray.assign(3 * s, 0.0);
    for (int y = 0; y < h; ++y) {
      for (int x = 0; x < w; ++x) {
        const std::size_t i = slot(x, y);
        if (masked && (x - 9) * (x - 9) + (y - 12) * (y - 12) < 20) continue;  // no ray: a hole
        const Eigen::Vector3d direction = random.direction();
        const bool hidden = masked && x > 20 && y < 4;
        for (std::size_t c = 0; c < 3; ++c) {
          ray[c * s + i] = direction[static_cast<Eigen::Index>(c)];
          truth[c * s + i] = hidden ? -1.0 : 0.5 + 0.3 * std::sin(0.4 * x + 0.2 * y + 1.0 * double(c));
          picture[c * s + i] = 0.5 + 0.3 * std::sin(0.37 * x + 0.21 * y) + 0.1 * random.normal();
        }
      }
    }
  }
  [[nodiscard]] std::size_t slot(int x, int y) const {
    const auto tile = static_cast<std::size_t>(y / 16) * frame.tiles_x + static_cast<std::size_t>(x / 16);
    const int block = y % 16 / 4 * 4 + x % 16 / 4;
    return tile * SIM_TILE_RAYS + static_cast<std::size_t>(block * 16 + y % 4 * 4 + x % 4);
  }
  [[nodiscard]] bool known(int x, int y) const {
    if (x < 0 || y < 0 || x >= width || y >= height) return false;
    const std::size_t i = slot(x, y);
    return ray[i] * ray[i] + ray[frame.slots + i] * ray[frame.slots + i] > 0.0 && truth[i] >= 0.0;
  }

  /// Returns the sum of 1 - SSIM from the definition, one 11 x 11 window after the other.
  [[nodiscard]] double dissimilarity() const {
    double sum = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          if (known(x, y)) sum += 1.0 - window_ssim(x, y, c * frame.slots);
        }
      }
    }
    return sum;
  }

  int width, height;
  shared::FrameParams frame{};
  std::vector<double> picture, truth, ray;

 private:
  [[nodiscard]] double window_ssim(int x0, int y0, std::size_t channel) const {
    double weight = 0.0, a = 0.0, b = 0.0, aa = 0.0, bb = 0.0, ab = 0.0;
    for (int y = y0 - 5; y <= y0 + 5; ++y) {
      for (int x = x0 - 5; x <= x0 + 5; ++x) {
        if (!known(x, y)) continue;
        const double w = std::exp(-((x - x0) * (x - x0) + (y - y0) * (y - y0)) / (2.0 * 1.5 * 1.5));
        const double p = picture[channel + slot(x, y)], t = truth[channel + slot(x, y)];
        weight += w;
        a += w * p;
        b += w * t;
        aa += w * p * p;
        bb += w * t * t;
        ab += w * p * t;
      }
    }
    a /= weight;
    b /= weight;
    const double va = aa / weight - a * a, vb = bb / weight - b * b, cov = ab / weight - a * b;
    return (2.0 * a * b + 1e-4) * (2.0 * cov + 9e-4) / ((a * a + b * b + 1e-4) * (va + vb + 9e-4));
  }
};

/// Lanes of the GPU shape, or of this device (0).
class Ssim : public testing::TestWithParam<std::pair<Precision, int>> {
 protected:
  [[nodiscard]] static Precision precision() { return GetParam().first; }
  struct Result {
    double sum = 0.0;
    std::vector<double> gradient;
  };
  /// The gradient buffer starts at 7, since the stage adds.
  Result run(SsimStage& stage, const Picture& p, double scale) {
    const auto buffer = [&](const std::vector<double>& values) {
      RealBuffer out(device_, "values", precision());
      out.assign(std::span<const double>(values));
      return out;
    };
    RealBuffer gradient = buffer(std::vector<double>(3 * p.frame.slots, 7.0));
    Result out;
    out.sum = stage.run(p.frame, buffer(p.ray), buffer(p.picture), buffer(p.truth), scale, gradient);
    out.gradient = gradient.download_double();
    for (double& g : out.gradient) g -= 7.0;
    return out;
  }
  Device device_ = test::device();
};

TEST_P(Ssim, MatchesTheLoopWithHolesMasksAndBorders) {
  if (precision() == Precision::kDouble) SIMULI_NEEDS_DOUBLE(device_);
  SsimStage stage(device_, precision(), GetParam().second);
  const double tolerance = precision() == Precision::kDouble ? kDoubleMeanTolerance : kFloatMeanTolerance;
  // One stage for pictures of several sizes: margins are cleared each time.
  for (const auto& [width, height, masked] : {std::tuple{40, 23, true},
                                              std::tuple{70, 40, false},
                                              std::tuple{40, 23, true},
                                              std::tuple{5, 3, false}}) {
    const Picture p(width, height, masked);
    const double expected = p.dissimilarity();
    EXPECT_GT(expected, 0.0);
    EXPECT_NEAR(run(stage, p, 1.0).sum, expected, tolerance * 3.0 * width * height);
  }
}

/// Difference quotients are inaccurate in float.
class SsimInDouble : public Ssim {};

TEST_P(SsimInDouble, GradientMatchesQuotientsAndWrongOnesDoNot) {
  SIMULI_NEEDS_DOUBLE(device_);
  SsimStage stage(device_, precision(), GetParam().second);
  Picture p(40, 23, true);
  constexpr double kScale = 0.37, kStep = 1e-4;
  const std::vector<double> gradient = run(stage, p, kScale).gradient;
  double largest = 0.0;
  for (const double g : gradient) largest = std::max(largest, std::abs(g));
  double error = 0.0, error_if_scaled = 0.0;
  // A corner, the border, beside the hole and the mask, where tiles meet, and the far corner.
  for (const auto& [x, y] :
       {std::pair{0, 0}, {17, 0}, {9, 7}, {20, 3}, {21, 4}, {15, 15}, {16, 16}, {39, 22}}) {
    for (std::size_t c = 0; c < 3; ++c) {
      ASSERT_TRUE(p.known(x, y));
      const std::size_t i = c * p.frame.slots + p.slot(x, y);
      const double before = p.picture[i];
      const auto at = [&](double by) {
        p.picture[i] = before + by;
        return kScale * run(stage, p, kScale).sum;
      };
      const auto central = [&](double h) { return (at(h) - at(-h)) / (2.0 * h); };
      const double quotient = (4.0 * central(0.5 * kStep) - central(kStep)) / 3.0;
      p.picture[i] = before;
      error = std::max(error, std::abs(quotient - gradient[i]));
      error_if_scaled = std::max(error_if_scaled, std::abs(quotient - 1.01 * gradient[i]));
    }
  }
  EXPECT_LE(error, kGradientTolerance * largest);
  EXPECT_GT(error_if_scaled, kGradientTolerance * largest);
  for (int y = 0; y < p.height; ++y) {
    for (int x = 0; x < p.width; ++x) {
      if (p.known(x, y)) continue;
      ASSERT_EQ(gradient[p.slot(x, y)], 0.0);
    }
  }
}

TEST_P(Ssim, EqualPicturesHaveNeitherLossNorGradient) {
  if (precision() == Precision::kDouble) SIMULI_NEEDS_DOUBLE(device_);
  SsimStage stage(device_, precision(), GetParam().second);
  Picture p(40, 23, true);
  p.picture = p.truth;
  const Result result = run(stage, p, 1.0);
  const double rounding = precision() == Precision::kDouble ? 1e-12 : 2e-3;  // float: 3e-7 / C2
  EXPECT_NEAR(result.sum, 0.0, rounding * 3.0 * 40.0 * 23.0);
  for (const double g : result.gradient) ASSERT_NEAR(g, 0.0, 10.0 * rounding);
}

INSTANTIATE_TEST_SUITE_P(All, SsimInDouble, testing::Values(std::pair{Precision::kDouble, 0}));
INSTANTIATE_TEST_SUITE_P(All,
                         Ssim,
                         testing::Values(std::pair{Precision::kFloat, 0},
                                         std::pair{Precision::kFloat, 1},
                                         std::pair{Precision::kDouble, 0}),
                         [](const auto& pair) {
                           return std::string(pair.param.first == Precision::kFloat ? "in_float"
                                                                                        : "in_double") +
                                  (pair.param.second == 1 ? "_gpu_shape" : "");
                         });

}  // namespace loss_ssim_test
}  // namespace simuli

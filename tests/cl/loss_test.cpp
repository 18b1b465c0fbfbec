// Tests losses against the same formulas in double, and their gradients against difference quotients.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <utility>
#include <vector>

#include "host/device/render/train/loss_stages.hpp"
#include "tests/cl/support.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

constexpr std::size_t kTiles = 3;
constexpr std::size_t kSlots = kTiles * SIM_TILE_RAYS;
// Sums of 768 terms with distances of up to 50 m: 24 bits of each and of the running sum.
constexpr double kFloatSumTolerance = 2e-6;
// A difference of two floats of size 10, times 4.
constexpr double kSlopeTolerance = 1e-6;
// Losses are piecewise smooth; quotients of a loss near 1 at steps of 1e-4 are good to 1e-8.
constexpr double kQuotientTolerance = 1e-6;

/// Random rendered outputs; every seventh slot has no ray.
struct Rendered {
  explicit Rendered(const Device& device, Precision precision)
      : buffers(device, precision), gradients(device, precision) {
    frame.tiles_x = kTiles;
    frame.tile_rays = SIM_TILE_RAYS;
    frame.tiles_y = 1;
    frame.slots = kSlots;
    test::Random random(17);
    out.resize(SIM_OUTPUTS * kSlots);
    std::vector<double> world_ray(3 * kSlots);
    for (std::size_t i = 0; i < kSlots; ++i) {
      const double transmittance = i % 11 == 0 ? 0.9995 : random.uniform(0.0, 0.95);
      out[i] = random.uniform(0.0, 1.0);
      out[kSlots + i] = 3.0 * random.normal();
      out[2 * kSlots + i] = 3.0 * random.normal();
      out[SIM_O_TRANSMITTANCE * kSlots + i] = transmittance;
      out[SIM_O_DISTANCE * kSlots + i] = (1.0 - transmittance) * random.uniform(2.0, 50.0);
      const Eigen::Vector3d direction = i % 7 == 0 ? Eigen::Vector3d::Zero() : random.direction();
      for (std::size_t k = 0; k < 3; ++k) {
        world_ray[k * kSlots + i] = direction[static_cast<Eigen::Index>(k)];
      }
    }
    buffers.rays.world_ray.assign(std::span<const double>(world_ray));
    drop = test::some_ray_drop(29);
    upload();
  }
  ImageLoss image_loss(ImageLossStage& stage, const RealBuffer& truth, const ImageLossScale& scale) {
    return stage.run(frame, buffers.rays, buffers.blended.out, buffers.blended.out, truth, scale, gradients);
  }
  LidarLoss lidar_loss(LidarLossStage& stage, const RealBuffer& truth, const LidarLossScale& scale) {
    return stage.run(frame, buffers.constants, buffers.rays, buffers.blended, truth, scale, gradients);
  }
  void upload() {
    buffers.blended.out.assign(std::span<const double>(out));
    shared::SensorConstants<double> sensor{};
    sensor.drop = shared::from_reals<shared::DropConstants>(drop);
    buffers.constants.sensor.assign(shared::reals_of(sensor));
  }
  [[nodiscard]] static bool fired(std::size_t slot) { return slot % 7 != 0; }

  shared::FrameParams frame{};
  FrameBuffers buffers;
  GradientBuffers gradients;
  std::vector<double> out;
  RayDrop::Parameters drop{};
};

std::vector<double> random_truth(std::size_t channels, double low, double high, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<double> truth(channels * kSlots);
  for (double& t : truth) t = random.uniform(low, high);
  return truth;
}

class Loss : public testing::TestWithParam<std::pair<Precision, std::size_t>> {
 protected:
  [[nodiscard]] static Precision precision() { return GetParam().first; }
  [[nodiscard]] double sum_tolerance() const {
    return precision() == Precision::kDouble ? 1e-12 : kFloatSumTolerance;
  }
  Device device_ = test::device();
};

TEST_P(Loss, PictureMatchesTheLoopAndItsQuotients) {
  if (precision() == Precision::kDouble) SIMULI_NEEDS_DOUBLE(device_);
  Rendered rendered(device_, precision());
  ImageLossStage stage(device_, precision(), GetParam().second);
  const std::vector<double> truth_values = random_truth(3, 0.0, 1.0, 5);
  RealBuffer truth(device_, "truth", precision());
  truth.assign(std::span<const double>(truth_values));
  constexpr double kScale = 0.37, kSquaredScale = 1.9;
  const ImageLoss loss = rendered.image_loss(stage, truth, {kScale, kSquaredScale, 0.0});
  const std::vector<double> grad = rendered.gradients.grad_out.download_double();

  double absolute = 0.0, squared = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < kSlots; ++i) {
      if (!Rendered::fired(i)) {
        ASSERT_EQ(grad[c * kSlots + i], 0.0);
        continue;
      }
      const double d = rendered.out[c * kSlots + i] - truth_values[c * kSlots + i];
      absolute += std::abs(d);
      squared += d * d;
      const double slope = (d > 0.0 ? kScale : -kScale) + 2.0 * kSquaredScale * d;
      ASSERT_NEAR(grad[c * kSlots + i], slope, kSlopeTolerance * (1.0 + std::abs(slope)));
    }
  }
  EXPECT_NEAR(loss.absolute, absolute, sum_tolerance() * absolute);
  EXPECT_NEAR(loss.squared, squared, sum_tolerance() * squared);
  for (std::size_t i = 3 * kSlots; i < 5 * kSlots; ++i) ASSERT_EQ(grad[i], 0.0);

  if (precision() == Precision::kFloat) return;
  for (const std::size_t i : {1UL, 300UL, 700UL, kSlots + 5, 2 * kSlots + 500}) {
    const double before = rendered.out[i];
    const auto at = [&](double step) {
      rendered.out[i] = before + step;
      rendered.upload();
      const ImageLoss stepped = rendered.image_loss(stage, truth, {kScale, kSquaredScale, 0.0});
      return kScale * stepped.absolute + kSquaredScale * stepped.squared;
    };
    EXPECT_NEAR((at(1e-4) - at(-1e-4)) / 2e-4, grad[i], kQuotientTolerance) << i;
    rendered.out[i] = before;
  }
}

TEST_P(Loss, SkyAsksForNothingNearAndLetsWhatIsFarBe) {
  if (precision() == Precision::kDouble) SIMULI_NEEDS_DOUBLE(device_);
  Rendered rendered(device_, precision());
  ImageLossStage stage(device_, precision(), GetParam().second);
  std::vector<double> truth_values = random_truth(4, 0.0, 1.0, 5);
  for (std::size_t i = 0; i < kSlots; ++i) {
    truth_values[3 * kSlots + i] = i % 3 == 0 ? 1.0 : 0.0;
    if (i % 5 == 0) truth_values[i] = -1.0;  // unknown
  }
  RealBuffer truth(device_, "truth", precision());
  truth.assign(std::span<const double>(truth_values));
  constexpr double kSkyFrom_m = 16.0;
  static_cast<void>(
      rendered.image_loss(stage, truth, {.absolute = 1.0, .sky = 0.25, .sky_from_m = kSkyFrom_m}));
  const std::vector<double> grad = rendered.gradients.grad_out.download_double();
  std::size_t near = 0, far = 0;
  for (std::size_t i = 0; i < kSlots; ++i) {
    const bool is_sky = i % 3 == 0 && i % 5 != 0 && Rendered::fired(i);
    const double opacity = 1.0 - rendered.out[SIM_O_TRANSMITTANCE * kSlots + i];
    const bool is_near = opacity > rendered.out[SIM_O_DISTANCE * kSlots + i] / kSkyFrom_m;
    (is_near ? near : far) += is_sky ? 1 : 0;
    ASSERT_EQ(grad[SIM_O_TRANSMITTANCE * kSlots + i], is_sky && is_near ? -0.25 : 0.0) << i;
    ASSERT_EQ(grad[SIM_O_DISTANCE * kSlots + i], is_sky && is_near ? -0.25 / kSkyFrom_m : 0.0) << i;
  }
  EXPECT_GT(near, 10U);
  EXPECT_GT(far, 10U);
}

/// Terms of one ray of a sweep, from their definition.
struct RayTerms {
  double distance = 0.0, intensity = 0.0, entropy = 0.0, wrong = 0.0;
};
RayTerms terms_of(const std::vector<double>& out,
                  const RayDrop::Parameters& drop,
                  const std::vector<double>& truth,
                  std::size_t i) {
  RayTerms terms;
  const bool returned = truth[i] > 0.0;
  const double opacity = 1.0 - out[SIM_O_TRANSMITTANCE * kSlots + i];
  if (returned) terms.intensity = std::abs(out[i] - truth[kSlots + i]);
  if (returned && opacity > 1e-3) {
    terms.distance = std::abs(out[SIM_O_DISTANCE * kSlots + i] / opacity - truth[i]) *
                     std::sqrt(10.0 / std::max(truth[i], 1.0));
  }
  const double logit = reference::drop_logit(drop,
                                             {.feature = {out[i], out[kSlots + i], out[2 * kSlots + i]},
                                              .transmittance = out[SIM_O_TRANSMITTANCE * kSlots + i],
                                              .distance = out[SIM_O_DISTANCE * kSlots + i]});
  const double p = 1.0 / (1.0 + std::exp(-logit));
  terms.entropy = -std::log(returned ? 1.0 - p : p);
  terms.wrong = (p > 0.5) == returned ? 1.0 : 0.0;
  return terms;
}

/// Returns d(cross entropy) / dT of a ray with its mean distance fixed.
double slope_by_transmittance(const Rendered& rendered, const std::vector<double>& truth, std::size_t i) {
  const auto entropy = [&](double by) {
    std::vector<double> out = rendered.out;
    // The input is O m / (m + 20 m) with the mean distance m: chooses m so that it remains constant.
    const double opacity = 1.0 - out[SIM_O_TRANSMITTANCE * kSlots + i];
    const double sum = out[SIM_O_DISTANCE * kSlots + i];
    const double input = opacity * sum / (sum + 20.0 * opacity);
    const double other = opacity - by;
    out[SIM_O_TRANSMITTANCE * kSlots + i] += by;
    out[SIM_O_DISTANCE * kSlots + i] = 20.0 * other * input / (other - input);
    return terms_of(out, rendered.drop, truth, i).entropy;
  };
  return (entropy(1e-6) - entropy(-1e-6)) / 2e-6;
}

TEST_P(Loss, SweepMatchesTheLoopAndItsQuotients) {
  if (precision() == Precision::kDouble) SIMULI_NEEDS_DOUBLE(device_);
  Rendered rendered(device_, precision());
  LidarLossStage stage(device_, precision(), GetParam().second);
  std::vector<double> truth_values = random_truth(2, 0.0, 1.0, 6);
  // A third has no return, some ranges are below 1 m; the second channel remains an intensity.
  for (std::size_t i = 0; i < kSlots; ++i) truth_values[i] = i % 3 == 0 ? 0.0 : 0.5 + 49.5 * truth_values[i];
  RealBuffer truth(device_, "truth", precision());
  truth.assign(std::span<const double>(truth_values));
  constexpr LidarLossScale kScale{0.11, 0.7, 0.3, 0.45};
  const LidarLoss loss = rendered.lidar_loss(stage, truth, kScale);
  const std::vector<double> grad = rendered.gradients.grad_out.download_double();

  RayTerms sum;
  for (std::size_t i = 0; i < kSlots; ++i) {
    if (!Rendered::fired(i)) {
      for (std::size_t row = 0; row < 5; ++row) ASSERT_EQ(grad[row * kSlots + i], 0.0) << i;
      continue;
    }
    const RayTerms terms = terms_of(rendered.out, rendered.drop, truth_values, i);
    sum.distance += terms.distance;
    sum.intensity += terms.intensity;
    sum.entropy += terms.entropy;
    sum.wrong += terms.wrong;
  }
  EXPECT_NEAR(loss.distance_m, sum.distance, sum_tolerance() * sum.distance);
  EXPECT_NEAR(loss.intensity, sum.intensity, sum_tolerance() * sum.intensity);
  EXPECT_NEAR(loss.entropy, sum.entropy, sum_tolerance() * sum.entropy);
  EXPECT_EQ(loss.wrong, sum.wrong);

  if (precision() == Precision::kFloat) return;
  const auto total = [&](const LidarLossScale& scale) {
    rendered.upload();
    const LidarLoss l = rendered.lidar_loss(stage, truth, scale);
    return scale.distance * l.distance_m + scale.intensity * l.intensity + scale.entropy * l.entropy;
  };
  for (std::size_t row = 0; row < 5; ++row) {
    for (const std::size_t slot :
         {1UL, 3UL, 11UL, 22UL, 44UL, 301UL, 512UL, 700UL}) {  // 11, 22, 44: nearly transparent
      const std::size_t i = row * kSlots + slot;
      const double before = rendered.out[i];
      const double step = row == SIM_O_TRANSMITTANCE ? 1e-6 : 1e-4;
      // The drop loss has no gradient by intensity and distance.
      LidarLossScale scale = kScale;
      if (row == 0 || row >= SIM_O_TRANSMITTANCE) scale.entropy = 0.0;
      const auto at = [&](double by) {
        rendered.out[i] = before + by;
        return total(scale);
      };
      double quotient = (at(step) - at(-step)) / (2.0 * step);
      rendered.out[i] = before;
      if (row == SIM_O_TRANSMITTANCE && Rendered::fired(slot))
        quotient += kScale.entropy * slope_by_transmittance(rendered, truth_values, slot);
      EXPECT_NEAR(quotient, grad[i], kQuotientTolerance * (1.0 + std::abs(grad[i]))) << row << " " << slot;
    }
  }
  const double to_function = kScale.function_entropy / kScale.entropy;
  for (std::size_t k = 0; k < RayDrop::kParameters; ++k) {
    const double before = rendered.drop[k];
    const auto at = [&](double by) {
      rendered.drop[k] = before + by;
      return to_function * total({0.0, 0.0, kScale.entropy, 0.0});
    };
    const double quotient = (at(1e-4) - at(-1e-4)) / 2e-4;
    rendered.drop[k] = before;
    EXPECT_NEAR(quotient, loss.drop[k], 1e-5 * (1.0 + std::abs(loss.drop[k]))) << k;
  }
}

INSTANTIATE_TEST_SUITE_P(All,
                         Loss,
                         testing::Values(std::pair{Precision::kFloat, std::size_t{1}},
                                         std::pair{Precision::kDouble, std::size_t{1}},
                                         std::pair{Precision::kFloat, std::size_t{32}},
                                         std::pair{Precision::kDouble, std::size_t{32}}),
                         [](const auto& pair) {
                           return std::string(pair.param.second == 1 ? "cpu" : "gpu") +
                                  (pair.param.first == Precision::kFloat ? "_in_float" : "_in_double");
                         });

}  // namespace
}  // namespace simuli

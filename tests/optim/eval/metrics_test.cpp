#include "optim/base/metrics.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <string>

#include "host/core/base/error.hpp"
#include "host/core/base/interruption.hpp"
#include "tests/support/scenes.hpp"

namespace simuli {
namespace {

using test::Random;

constexpr double kDouble = 1e-12;  // a few roundings of double sums of values around 1
constexpr double kSingle = 1e-6;   // inputs are stored in single precision

Image noise(int width, int height, int channels, std::uint64_t seed) {
  Random random(seed);
  Image image(width, height, channels);
  for (float& value : image.data) value = static_cast<float>(random.uniform(0.0, 1.0));
  return image;
}

Image constant(int side, float value) {
  Image image(side, side, 1);
  std::fill(image.data.begin(), image.data.end(), value);
  return image;
}

/// Returns SSIM from its definition: the full 2D window and central moments, pixel by pixel.
double ssim_by_definition(const Image& a, const Image& b) {
  double total = 0.0;
  int count = 0;
  for (int c = 0; c < a.channels; ++c) {
    for (int y = 5; y < a.height - 5; ++y) {
      for (int x = 5; x < a.width - 5; ++x) {
        const auto average = [&](auto&& value) {
          double sum = 0.0;
          double weights = 0.0;
          for (int v = -5; v <= 5; ++v) {
            for (int u = -5; u <= 5; ++u) {
              const double weight = std::exp(-(u * u + v * v) / (2.0 * 1.5 * 1.5));
              sum += weight * value(static_cast<double>(a.at(x + u, y + v, c)),
                                    static_cast<double>(b.at(x + u, y + v, c)));
              weights += weight;
            }
          }
          return sum / weights;
        };
        const double mean_a = average([](double p, double) { return p; });
        const double mean_b = average([](double, double q) { return q; });
        const double var_a = average([&](double p, double) { return (p - mean_a) * (p - mean_a); });
        const double var_b = average([&](double, double q) { return (q - mean_b) * (q - mean_b); });
        const double cov = average([&](double p, double q) { return (p - mean_a) * (q - mean_b); });
        total += (2.0 * mean_a * mean_b + 1e-4) * (2.0 * cov + 9e-4) /
                 ((mean_a * mean_a + mean_b * mean_b + 1e-4) * (var_a + var_b + 9e-4));
        ++count;
      }
    }
  }
  return total / count;
}

TEST(Psnr, LeavesOutWhatIsNotKnown) {
  const Image a = noise(20, 16, 3, 1);
  Image b = noise(20, 16, 3, 2), known_a(20, 9, 3), known_b(20, 9, 3);
  std::copy_n(a.data.begin(), known_a.data.size(), known_a.data.begin());
  std::copy_n(b.data.begin(), known_b.data.size(), known_b.data.begin());
  std::fill(b.data.begin() + static_cast<std::ptrdiff_t>(known_b.data.size()), b.data.end(), -1.0F);
  EXPECT_NEAR(psnr_db(a, b), psnr_db(known_a, known_b), kDouble);
  std::fill(b.data.begin(), b.data.end(), -1.0F);
  EXPECT_TRUE(std::isnan(psnr_db(a, b)));
}

TEST(Ssim, LeavesOutWindowsWithWhatIsNotKnown) {
  const Image a = noise(30, 24, 3, 3);
  Image b = noise(30, 24, 3, 4), known_a(30, 20, 3), known_b(30, 20, 3);
  std::copy_n(a.data.begin(), known_a.data.size(), known_a.data.begin());
  std::copy_n(b.data.begin(), known_b.data.size(), known_b.data.begin());
  std::fill(b.data.begin() + static_cast<std::ptrdiff_t>(known_b.data.size()), b.data.end(), -1.0F);
  EXPECT_NEAR(ssim(a, b), ssim(known_a, known_b), kDouble);
  for (int c = 0; c < 3; ++c) b.data[3 * (10 * 30 + 15) + static_cast<std::size_t>(c)] = -1.0F;
  EXPECT_NE(ssim(a, b), ssim(known_a, known_b));
  EXPECT_TRUE(std::isfinite(ssim(a, b)));  // neighbouring windows remain
}

TEST(Psnr, IsTwentyDbAtAnErrorOfATenth) {
  EXPECT_NEAR(psnr_db(constant(4, 0.5F), constant(4, 0.6F)), 20.0, 1e-5);  // 0.1 in float: 1e-6 dB
}

TEST(Psnr, AveragesSquaresOverAllValues) {
  Image rendered(2, 1, 3);
  Image truth(2, 1, 3);
  rendered.at(1, 0, 2) = 0.5F;  // one value of six has an error of one half
  EXPECT_NEAR(psnr_db(rendered, truth), 10.0 * std::log10(6.0 / 0.25), kDouble * 100);
}

TEST(Psnr, IdenticalPicturesAreInfinite) {
  const Image image = noise(7, 5, 3, 1);
  EXPECT_EQ(psnr_db(image, image), std::numeric_limits<double>::infinity());
}

/// 48 x 32 px.
template <class At>
Image picture(const At& at) {
  Image image(48, 32, 3);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int k = 0; k < 3; ++k) image.at(x, y, k) = static_cast<float>(at(x, y, k));
    }
  }
  return image;
}

// Values of the authors' program (flip-evaluator 1.7) for the same pictures.
TEST(Flip, IsThatOfItsAuthors) {
  const auto wave = [](int x, int y, int k) { return 0.5 + 0.4 * std::sin(0.37 * x + 0.11 * (k + 1) * y); };
  const auto disc = [](int x, int y, int k) {
    return (x - 24) * (x - 24) + (y - 16) * (y - 16) < 100 ? 0.9 : 0.1 + 0.1 * k;
  };
  const Image truth = picture(wave);
  const auto against = [&](const auto& at) { return flip(picture(at), truth); };
  constexpr double kTheirFloats = 2e-5;
  EXPECT_NEAR(against([&](int x, int y, int k) { return wave(x - 1, y, k); }), 0.4539427, kTheirFloats);
  EXPECT_NEAR(against([&](int x, int y, int k) { return (1.0 - 0.05 * k * (k + 1)) * wave(x, y, k); }),
              0.4838561,
              kTheirFloats);
  EXPECT_NEAR(against([](int, int, int) { return 0.5; }), 0.8164675, kTheirFloats);
  EXPECT_NEAR(against([&](int x, int y, int k) { return 1.0 - wave(x, y, k); }), 0.9083958, kTheirFloats);
  EXPECT_NEAR(flip(picture([&](int x, int y, int k) { return disc(x - 1, y, k); }), picture(disc)),
              0.0807104,
              kTheirFloats);
  EXPECT_EQ(flip(truth, truth), 0.0);
}

TEST(Flip, LeavesOutWhatIsNotKnown) {
  Image truth = noise(48, 32, 3, 9), rendered = noise(48, 32, 3, 10);
  std::copy_n(truth.data.begin() + 20 * 48 * 3, 12 * 48 * 3, rendered.data.begin() + 20 * 48 * 3);
  const double whole = flip(rendered, truth);
  std::fill_n(truth.data.begin(), 30 * 48 * 3, -1.0F);
  EXPECT_GT(whole, 0.1);
  EXPECT_LT(flip(rendered, truth), 1e-6);  // the known part is equal, and the unknown part is ignored
  std::fill(truth.data.begin(), truth.data.end(), -1.0F);
  EXPECT_TRUE(std::isnan(flip(rendered, truth)));
  EXPECT_TRUE(std::isnan(flip(constant(12, 0.5F), constant(12, 0.5F))));
}

TEST(PsnrCorrected, SeesNoTint) {
  const Image truth = noise(16, 12, 3, 5);
  Image tinted = truth, noisy = truth;
  const Image other = noise(16, 12, 3, 6);
  for (std::size_t i = 0; i < truth.data.size(); i += 3) {
    const float* const t = &truth.data[i];
    tinted.data[i] = 0.1F + 0.5F * t[0] + 0.2F * t[1];
    tinted.data[i + 1] = 0.3F * t[1] - 0.1F * t[2];
    tinted.data[i + 2] = 0.9F * t[2];
    for (std::size_t c = i; c < i + 3; ++c) noisy.data[c] = tinted.data[c] + 0.05F * other.data[c];
  }
  EXPECT_LT(psnr_db(tinted, truth), 20.0);
  EXPECT_GT(psnr_corrected_db(tinted, truth), 100.0);
  EXPECT_GT(psnr_corrected_db(noisy, truth), psnr_db(noisy, truth) + 10.0);
  EXPECT_LT(psnr_corrected_db(noisy, truth), 40.0);  // noise is no tint
  EXPECT_LT(psnr_corrected_db(other, truth), 12.0);  // no transform maps one to the other
}

TEST(ColourCorrected, FollowsAToneCurveWhereAsked) {
  const Image rendered = noise(16, 12, 3, 11);
  Image truth = rendered;
  for (float& value : truth.data) value = 0.05F + 0.3F * value + 0.6F * value * value;
  EXPECT_LT(psnr_db(colour_corrected(rendered, truth), truth), 35.0);
  EXPECT_GT(psnr_db(colour_corrected(rendered, truth, {}, Tone::kQuadratic), truth), 100.0);
}

TEST(PsnrCorrected, IsNeverBelowThePlainOne) {
  const Image truth = noise(16, 12, 3, 7);
  EXPECT_TRUE(std::isinf(psnr_corrected_db(truth, truth)));
  const Image grey = constant(12, 0.5F);  // many transforms are equally close
  EXPECT_TRUE(std::isinf(psnr_corrected_db(grey, grey)));
  EXPECT_GT(psnr_corrected_db(grey, constant(12, 0.25F)), 100.0);
}

TEST(PsnrCorrected, LeavesOutWhatIsNotKnown) {
  Image truth = noise(16, 12, 3, 8);
  Image rendered = truth;
  for (std::size_t i = 0; i < truth.data.size(); ++i) rendered.data[i] = 0.5F * truth.data[i];
  for (std::size_t c = 0; c < 3; ++c) truth.data[c] = -1.0F;
  rendered.data[0] = 100.0F;
  EXPECT_GT(psnr_corrected_db(rendered, truth), 100.0);
  std::fill(truth.data.begin(), truth.data.end(), -1.0F);
  EXPECT_TRUE(std::isnan(psnr_corrected_db(rendered, truth)));
}

TEST(Psnr, UnequalSizesAreRefused) {
  try {
    (void)psnr_db(constant(4, 0.0F), constant(5, 0.0F));
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInput);
    EXPECT_NE(std::string(error.what()).find("4x4x1"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("5x5x1"), std::string::npos) << error.what();
  }
  EXPECT_THROW((void)psnr_db(Image(), Image()), Error);
}

TEST(Metrics, HearWhoInterrupts) {
  const Image image = noise(48, 32, 3, 2);
  for (const auto metric : {ssim, flip}) {
    int looks = 0;
    const std::function<void()> look = [&] { ++looks; };
    const Interruption interruption(look);
    (void)metric(image, image);
    EXPECT_GT(looks, 20);
  }
}

TEST(Ssim, IsOneForIdenticalPictures) {
  const Image image = noise(19, 14, 3, 2);
  EXPECT_NEAR(ssim(image, image), 1.0, kDouble);
}

TEST(Ssim, OfTwoConstantsIsTheLuminanceTerm) {
  const double a = 0.25;
  const double b = 0.75;
  EXPECT_NEAR(
      ssim(constant(12, 0.25F), constant(12, 0.75F)), (2 * a * b + 1e-4) / (a * a + b * b + 1e-4), kDouble);
}

TEST(Ssim, AgreesWithItsDefinition) {
  for (const int channels : {1, 3}) {
    const Image a = noise(23, 17, channels, 3);
    Image b = noise(23, 17, channels, 4);
    for (std::size_t i = 0; i < b.data.size(); ++i) b.data[i] = 0.6F * a.data[i] + 0.4F * b.data[i];
    const double expected = ssim_by_definition(a, b);
    EXPECT_GT(expected, 0.3);
    EXPECT_LT(expected, 0.95);
    EXPECT_NEAR(ssim(a, b), expected, kDouble);
    EXPECT_NEAR(ssim(b, a), expected, kDouble);
  }
}

TEST(Ssim, NeedsElevenPixels) {
  EXPECT_NO_THROW((void)ssim(constant(11, 0.0F), constant(11, 0.0F)));
  EXPECT_THROW((void)ssim(constant(10, 0.0F), constant(10, 0.0F)), Error);
}

SweepComparison sweep_of(std::size_t rays) {
  SweepComparison sweep;
  for (std::vector<float>* values :
       {&sweep.range, &sweep.intensity, &sweep.drop, &sweep.truth_range, &sweep.truth_intensity}) {
    values->assign(rays, 0.0F);
  }
  sweep.origin.assign(rays, Eigen::Vector3f::Zero());
  sweep.direction.assign(rays, Eigen::Vector3f::UnitX());
  return sweep;
}

TEST(SweepMetricsTest, MatchHandComputation) {
  // Four parallel rays 100 m apart, so that each point's neighbour is on its own ray if there is one. Ray 3
  // has no return and is predicted to drop; ray 2 is wrongly predicted to drop.
  SweepComparison sweep = sweep_of(4);
  sweep.range = {10.5F, 19.0F, 42.0F, 7.0F};
  sweep.truth_range = {10.0F, 20.0F, 40.0F, 0.0F};
  sweep.drop = {0.1F, 0.5F, 0.75F, 0.875F};  // 0.5 does not drop
  sweep.intensity = {0.5F, 0.25F, 0.25F, 1.0F};
  sweep.truth_intensity = {0.25F, 0.25F, 0.75F, 0.0F};
  for (int i = 0; i < 4; ++i) sweep.origin[static_cast<std::size_t>(i)].y() = 100.0F * static_cast<float>(i);
  const SweepMetrics metrics = compare_sweep(sweep);
  EXPECT_NEAR(metrics.distance_median_m, 1.0, kDouble);
  EXPECT_NEAR(metrics.medl2_m2, 1.0, kDouble);
  EXPECT_NEAR(metrics.mean_rel_l2, 3 * 0.0025 / 3, kDouble);  // 5 % on each
  EXPECT_NEAR(metrics.intensity_rmse, std::sqrt((0.0625 + 0.25) / 3), kDouble);
  EXPECT_NEAR(metrics.raydrop_accuracy, 0.75, kDouble);
  EXPECT_NEAR(metrics.raydrop_trivial, 0.75, kDouble);
  EXPECT_NEAR(metrics.drop_recall, 1.0, kDouble);
  EXPECT_NEAR(metrics.drop_precision, 0.5, kDouble);
  // G = (10,0) (20,100) (40,200), P = (10.5,0) (19,100); (19,100) is nearest to the third true point.
  const double lost_squared = 21.0 * 21.0 + 100.0 * 100.0;
  EXPECT_NEAR(metrics.chamfer_m2, (0.25 + 1.0 + 0.25 + 1.0 + lost_squared) / 3, kDouble * lost_squared);
  EXPECT_NEAR(metrics.chamfer_m, 0.5 * (1.5 / 2 + (1.5 + std::sqrt(lost_squared)) / 3), kDouble * 100);
}

TEST(SweepMetricsTest, DropsAreCountedBothWays) {
  // Of 10 rays 5 drop, 2 of them are predicted; 3 are predicted to drop.
  SweepComparison sweep = sweep_of(10);
  sweep.range.assign(10, 5.0F);
  for (std::size_t i = 5; i < 10; ++i) sweep.truth_range[i] = 5.0F;
  for (const std::size_t said : {0U, 4U, 9U}) sweep.drop[said] = 0.9F;
  const SweepMetrics metrics = compare_sweep(sweep);
  EXPECT_DOUBLE_EQ(metrics.raydrop_accuracy, 0.6);
  EXPECT_DOUBLE_EQ(metrics.raydrop_trivial, 0.5);
  EXPECT_DOUBLE_EQ(metrics.drop_recall, 0.4);
  EXPECT_DOUBLE_EQ(metrics.drop_precision, 2.0 / 3.0);
}

TEST(SweepMetricsTest, SharesOfNoDropsAreUndefined) {
  SweepComparison sweep = sweep_of(2);
  sweep.range = sweep.truth_range = {5.0F, 6.0F};
  EXPECT_TRUE(std::isnan(compare_sweep(sweep).drop_recall));     // none dropped
  EXPECT_TRUE(std::isnan(compare_sweep(sweep).drop_precision));  // none is predicted
  EXPECT_EQ(compare_sweep(sweep).raydrop_trivial, 1.0);
  sweep.drop = {0.9F, 0.0F};
  EXPECT_TRUE(std::isnan(compare_sweep(sweep).drop_recall));
  EXPECT_EQ(compare_sweep(sweep).drop_precision, 0.0);  // one is predicted wrongly
  EXPECT_EQ(compare_sweep(sweep).raydrop_accuracy, 0.5);
}

TEST(SweepMetricsTest, MedianOfAnEvenCountIsTheMeanOfTheMiddle) {
  SweepComparison sweep = sweep_of(4);
  sweep.truth_range.assign(4, 10.0F);
  sweep.range = {18.0F, 9.0F, 13.0F, 10.0F};  // |errors| 8, 1, 3, 0
  const SweepMetrics metrics = compare_sweep(sweep);
  EXPECT_NEAR(metrics.distance_median_m, 2.0, kDouble);
  EXPECT_NEAR(metrics.medl2_m2, 5.0, kDouble);  // squares 64, 1, 9, 0
}

TEST(SweepMetricsTest, ChamferAgreesWithBruteForce) {
  constexpr std::size_t kRays = 700;
  Random random(5);
  SweepComparison sweep = sweep_of(kRays);
  std::vector<Eigen::Vector3d> predicted;
  std::vector<Eigen::Vector3d> returned;
  for (std::size_t i = 0; i < kRays; ++i) {
    sweep.origin[i] = random.in_box({-1, -1, -1}, {1, 1, 1}).cast<float>();
    sweep.direction[i] = random.direction().cast<float>();
    sweep.range[i] = static_cast<float>(random.uniform(1.0, 60.0));
    sweep.truth_range[i] =
        random.uniform(0.0, 1.0) < 0.2 ? 0.0F : sweep.range[i] + static_cast<float>(random.uniform(0.0, 2.0));
    sweep.drop[i] = static_cast<float>(random.uniform(0.0, 1.0));
    const Eigen::Vector3d o = sweep.origin[i].cast<double>();
    const Eigen::Vector3d d = sweep.direction[i].cast<double>();
    if (sweep.drop[i] <= 0.5F) predicted.emplace_back(o + d * sweep.range[i]);
    if (sweep.truth_range[i] > 0.0F) returned.emplace_back(o + d * sweep.truth_range[i]);
  }
  double squared = 0.0;
  double unsquared[2] = {0.0, 0.0};
  const auto add = [&](const auto& from, const auto& to, double& mean) {
    for (const auto& p : from) {
      double best = std::numeric_limits<double>::infinity();
      for (const auto& g : to) best = std::min(best, (p - g).squaredNorm());
      squared += best;
      mean += std::sqrt(best) / static_cast<double>(from.size());
    }
  };
  add(predicted, returned, unsquared[0]);
  add(returned, predicted, unsquared[1]);
  ASSERT_NE(predicted.size(), returned.size());
  const SweepMetrics metrics = compare_sweep(sweep);
  const double chamfer_m2 = squared / static_cast<double>(returned.size());
  EXPECT_NEAR(metrics.chamfer_m2, chamfer_m2, kSingle * chamfer_m2);
  EXPECT_NEAR(metrics.chamfer_m, 0.5 * (unsquared[0] + unsquared[1]), kSingle);
}

TEST(SweepMetricsTest, CoincidentPointsHaveDistanceZero) {
  SweepComparison sweep = sweep_of(64);  // more equal points than the capacity of a tree leaf
  sweep.range.assign(64, 5.0F);
  sweep.truth_range.assign(64, 5.0F);
  const SweepMetrics metrics = compare_sweep(sweep);
  EXPECT_EQ(metrics.chamfer_m2, 0.0);
  EXPECT_EQ(metrics.chamfer_m, 0.0);
  EXPECT_EQ(metrics.raydrop_accuracy, 1.0);
}

TEST(SweepMetricsTest, NothingToCompareIsNaN) {
  SweepComparison none_returned = sweep_of(3);
  none_returned.range.assign(3, 5.0F);
  none_returned.drop.assign(3, 0.0F);
  const SweepMetrics metrics = compare_sweep(none_returned);
  for (const double value : {metrics.distance_median_m,
                             metrics.medl2_m2,
                             metrics.mean_rel_l2,
                             metrics.intensity_rmse,
                             metrics.chamfer_m2,
                             metrics.chamfer_m}) {
    EXPECT_TRUE(std::isnan(value)) << value;
  }
  EXPECT_EQ(metrics.raydrop_accuracy, 0.0);

  SweepComparison none_predicted = sweep_of(3);
  none_predicted.truth_range.assign(3, 5.0F);
  none_predicted.drop.assign(3, 1.0F);
  EXPECT_TRUE(std::isnan(compare_sweep(none_predicted).chamfer_m2));
  EXPECT_TRUE(std::isnan(compare_sweep(none_predicted).chamfer_m));
  EXPECT_EQ(compare_sweep(none_predicted).distance_median_m, 5.0);

  EXPECT_TRUE(std::isnan(compare_sweep(SweepComparison()).raydrop_accuracy));
}

TEST(SweepMetricsTest, BadInputIsRefusedByName) {
  const auto message = [](const SweepComparison& sweep) -> std::string {
    try {
      (void)compare_sweep(sweep);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kInput);
      return error.what();
    }
    return "";
  };
  SweepComparison sweep = sweep_of(3);
  sweep.drop.pop_back();
  EXPECT_NE(message(sweep).find("drop: found 2"), std::string::npos) << message(sweep);
  sweep = sweep_of(3);
  sweep.range[1] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_NE(message(sweep).find("range[1]"), std::string::npos) << message(sweep);
  sweep = sweep_of(3);
  sweep.truth_range[2] = -1.0F;
  EXPECT_NE(message(sweep).find("truth_range[2]"), std::string::npos) << message(sweep);
}

}  // namespace
}  // namespace simuli

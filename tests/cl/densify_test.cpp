// Tests relocation, growth and noise.
#include "host/device/render/train/densify.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <string>
#include <vector>

#include "tests/cl/support.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace densify_test {

constexpr double kDead = 0.005;

double sigma_of(double logit) { return 1.0 / (1.0 + std::exp(-logit)); }
float logit_of(double sigma) { return static_cast<float>(std::log(sigma / (1.0 - sigma))); }

/// A set in training with the data that relocation changes.
struct Trained {
  Trained(const Device& device, const GaussianSet& set, const std::vector<double>& errors)
      : particles(device, set, Precision::kFloat),
        first(device, "first", Precision::kFloat, particles.params.count()),
        second(device, "second", Precision::kFloat, particles.params.count()),
        error(device, "error", Precision::kFloat) {
    first.fill(1.0);
    second.fill(2.0);
    error.assign(std::span<const double>(errors));
  }
  DensifyCounts relocate(DensifyStage& densify, std::uint32_t growth, const RandomKey& key) {
    RealBuffer* const moments[] = {&first, &second};
    return densify.relocate(particles, moments, error, growth, key);
  }
  ParticleBuffers particles;
  RealBuffer first, second, error;
};

/// Returns a set with distinct rows, so that copies can be identified.
GaussianSet distinct_set(Eigen::Index count) {
  test::SetRecipe recipe;
  recipe.count = count;
  recipe.sh_degree = 1;
  recipe.opacity_min = 0.1;
  return test::random_set(recipe, 4);
}

class Densify : public testing::Test {
 protected:
  Device device_ = test::device();
  DensifyStage densify_{device_, Precision::kFloat};
};

TEST_F(Densify, SourcesAreDrawnInProportionToTheirError) {
  constexpr Eigen::Index kCount = 4004;
  GaussianSet set = distinct_set(kCount);
  set.opacity_logit().tail(kCount - 4).setConstant(logit_of(0.9 * kDead));
  std::vector<double> errors(kCount, 100.0);  // errors of dead particles, which are never drawn
  for (std::size_t i = 0; i < 4; ++i) errors[i] = 0.5 * static_cast<double>(i);
  const auto drawn = [&](const RandomKey& key) {
    Trained trained(device_, set, errors);
    const DensifyCounts counts = trained.relocate(densify_, 0, key);
    EXPECT_EQ(counts.relocated, 4000U);
    EXPECT_EQ(counts.grown, 0U);
    const GaussianSet after = trained.particles.download();
    std::vector<std::size_t> source;
    for (Eigen::Index i = 4; i < kCount; ++i) {
      for (Eigen::Index s = 0; s < 4; ++s) {
        if (after.mean().row(i) == set.mean().row(s)) source.push_back(static_cast<std::size_t>(s));
      }
    }
    EXPECT_EQ(source.size(), 4000U);
    return source;
  };
  const std::vector<std::size_t> source = drawn({.seed = 7, .iteration = 300, .set = 0});
  for (std::size_t s = 0; s < 4; ++s) {
    const double share = static_cast<double>(s) / 6.0;
    const auto found = static_cast<double>(std::count(source.begin(), source.end(), s));
    EXPECT_NEAR(found, 4000.0 * share, 4.5 * std::sqrt(4000.0 * share * (1.0 - share))) << s;
  }
  EXPECT_EQ(drawn({.seed = 7, .iteration = 300, .set = 0}), source);
  EXPECT_NE(drawn({.seed = 8, .iteration = 300, .set = 0}), source);
  EXPECT_NE(drawn({.seed = 7 + (std::uint64_t{1} << 32U), .iteration = 300, .set = 0}), source);
  EXPECT_NE(drawn({.seed = 7, .iteration = 400, .set = 0}), source);
  EXPECT_NE(drawn({.seed = 7, .iteration = 300, .set = 1}), source);
}

TEST_F(Densify, CopiesTogetherLookLikeTheirSource) {
  // One live particle, and one to sixty dead particles that are relocated to it.
  for (const Eigen::Index others : {1, 2, 5, 30, 60}) {
    GaussianSet set = distinct_set(others + 1);
    const double sigma = 0.95;
    set.opacity_logit().setConstant(logit_of(0.001));
    set.opacity_logit()(0) = logit_of(sigma);
    std::vector<double> errors(static_cast<std::size_t>(others) + 1, 1.0);
    Trained trained(device_, set, errors);
    EXPECT_EQ(trained.relocate(densify_, 0, {.seed = 1}).relocated, others);
    const GaussianSet after = trained.particles.download();
    const double each = sigma_of(static_cast<double>(after.opacity_logit()(0)));
    const double scale =
        std::exp(static_cast<double>(after.log_scale()(0, 0)) - static_cast<double>(set.log_scale()(0, 0)));
    const double copies = static_cast<double>(std::min<Eigen::Index>(others + 1, 51));
    EXPECT_NEAR(1.0 - std::pow(1.0 - each, copies), sigma, 2e-5) << others;
    // The integral of opacity across the particle is preserved.
    double integral = 0.0;
    constexpr double kStep = 1e-3;
    for (double x = -20.0; x < 20.0; x += kStep) {
      integral += kStep * (1.0 - std::pow(1.0 - each * std::exp(-0.5 * x * x / (scale * scale)), copies));
    }
    EXPECT_NEAR(integral, sigma * std::sqrt(2.0 * M_PI), 1e-3) << others;
    for (Eigen::Index i = 0; i <= others; ++i) {
      EXPECT_EQ(after.opacity_logit()(i), after.opacity_logit()(0));
      EXPECT_EQ(after.log_scale().row(i), after.log_scale().row(0));
      EXPECT_EQ(after.mean().row(i), set.mean().row(0));
      EXPECT_EQ(after.rotation().row(i), set.rotation().row(0));
      for (int k = 0; k < 4; ++k) EXPECT_EQ(after.sh(k).row(i), set.sh(k).row(0));
    }
  }
}

TEST_F(Densify, GrowthKeepsWhatIsThereAndStartsMomentsAnew) {
  constexpr Eigen::Index kCount = 100;
  constexpr std::uint32_t kGrowth = 37;
  GaussianSet set = distinct_set(kCount);
  set.opacity_logit()(17) = logit_of(0.001);
  std::vector<double> errors(kCount, 0.0);
  for (std::size_t i = 50; i < 60; ++i) errors[i] = 1.0;
  errors[58] = std::numeric_limits<double>::quiet_NaN();  // is ignored
  Trained trained(device_, set, errors);
  const std::uint32_t old_stride = trained.particles.stride;
  const DensifyCounts counts = trained.relocate(densify_, kGrowth, {.seed = 3, .iteration = 10});
  EXPECT_EQ(counts.relocated, 1U);
  EXPECT_EQ(counts.grown, kGrowth);
  EXPECT_EQ(trained.particles.count, kCount + kGrowth);
  EXPECT_GT(trained.particles.stride, old_stride);
  const GaussianSet after = trained.particles.download();
  ASSERT_EQ(after.size(), kCount + kGrowth);
  const std::size_t stride = trained.particles.stride;
  const std::vector<float> first = trained.first.download_float(), second = trained.second.download_float();
  const std::vector<float> params = trained.particles.params.download_float();
  ASSERT_EQ(first.size(), params.size());
  std::vector<int> copies(kCount, 0);
  for (Eigen::Index i = 0; i < after.size(); ++i) {
    if (i < kCount && i != 17) continue;
    Eigen::Index from = -1;
    for (Eigen::Index s = 0; s < kCount; ++s) {
      if (after.mean().row(i) == set.mean().row(s)) from = s;
    }
    ASSERT_TRUE(from >= 50 && from < 60 && from != 58) << i << " from " << from;
    ++copies[static_cast<std::size_t>(from)];
  }
  for (Eigen::Index i = 0; i < after.size(); ++i) {
    const bool is_new = i >= kCount || i == 17;
    const bool drawn = !is_new && copies[static_cast<std::size_t>(i)] > 0;
    if (drawn) {
      EXPECT_LT(after.opacity_logit()(i), set.opacity_logit()(i)) << i;
    } else if (!is_new) {
      EXPECT_EQ(after.params.row(i), set.params.row(i)) << i;
    }
    for (std::size_t row = 0; row < first.size() / stride; ++row) {
      const std::size_t at = row * stride + static_cast<std::size_t>(i);
      EXPECT_EQ(first[at], is_new || drawn ? 0.0F : 1.0F);
      EXPECT_EQ(second[at], is_new || drawn ? 0.0F : 2.0F);
    }
  }
  // Padding particles are invisible.
  for (std::size_t i = static_cast<std::size_t>(after.size()); i < stride; ++i) {
    EXPECT_EQ(params[kOpacityRow * stride + i], -80.0F);
    EXPECT_EQ(params[kRotationRow * stride + i], 1.0F);
  }
  EXPECT_EQ(trained.error.count(), static_cast<std::size_t>(after.size()));
  for (const float e : trained.error.download_float()) EXPECT_EQ(e, 0.0F);

  // Words that belong to particles are moved with them.
  std::vector<std::uint32_t> words;
  for (std::uint32_t i = 0; i < 3U * kCount; ++i) words.push_back(i);
  Buffer<std::uint32_t> anchors(device_, "anchors", words);
  densify_.follow(anchors, 3);
  const std::vector<std::uint32_t> followed = anchors.download();
  ASSERT_EQ(followed.size(), 3U * static_cast<std::size_t>(after.size()));
  for (Eigen::Index i = 0; i < after.size(); ++i) {
    Eigen::Index from = i;
    for (Eigen::Index s = 0; s < kCount; ++s) {
      if (after.mean().row(i) == set.mean().row(s)) from = s;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(followed[3 * static_cast<std::size_t>(i) + k], 3U * static_cast<std::uint32_t>(from) + k);
    }
  }
}

TEST_F(Densify, MembersOfActorsFollowTheirSources) {
  constexpr Eigen::Index kCount = 90;
  constexpr std::uint32_t kGrowth = 50;
  GaussianSet set = distinct_set(kCount);
  for (Eigen::Index i = 0; i < kCount; ++i) {
    set.actor.push_back(static_cast<std::uint32_t>(i % 3));
    if (i % 4 == 0) set.opacity_logit()(i) = logit_of(0.001);
  }
  // A particle's box follows from its mean: particles of an actor are in a box without other particles.
  std::vector<Actor> actors(2);
  for (Actor& actor : actors) actor.size_m = {4.0, 2.0, 1.5};
  for (Eigen::Index i = 0; i < kCount; ++i) {
    const auto sign = static_cast<float>(set.actor[static_cast<std::size_t>(i)] == 1 ? 1 : -1);
    for (Eigen::Index k = 0; k < 3; ++k) {
      float& x = set.mean()(i, k);
      x = set.actor[static_cast<std::size_t>(i)] == 0 ? x + 100.0F
                                                      : sign * (0.1F + 0.006F * static_cast<float>(i));
    }
  }
  Trained trained(device_, set, std::vector<double>(kCount, 1.0));
  const DensifyCounts counts = trained.relocate(densify_, kGrowth, {.seed = 5});
  EXPECT_EQ(counts.relocated, 23U);
  const GaussianSet after = trained.particles.download();
  ASSERT_EQ(after.actor.size(), kCount + kGrowth);
  std::size_t changed = 0;
  for (Eigen::Index i = 0; i < after.size(); ++i) {
    const std::uint32_t actor = after.actor[static_cast<std::size_t>(i)];
    Eigen::Index from = -1;
    for (Eigen::Index s = 0; s < kCount; ++s) {
      if (after.mean().row(i) == set.mean().row(s)) from = s;
    }
    ASSERT_GE(from, 0);
    EXPECT_EQ(actor, set.actor[static_cast<std::size_t>(from)]) << i;
    if (i < kCount && actor != set.actor[static_cast<std::size_t>(i)]) ++changed;
  }
  EXPECT_GT(changed, 5U);
  // The tables of the actors contain the new members.
  EXPECT_EQ(trained.particles.actors, 2U);
  EXPECT_EQ(trained.particles.actor_of.count(), trained.particles.stride);
  const std::vector<std::uint32_t> first = trained.particles.actor_first.download();
  const std::vector<std::uint32_t> list = trained.particles.actor_list.download();
  std::vector<std::uint32_t> expected, starts{0};
  for (std::uint32_t actor = 1; actor <= 2; ++actor) {
    for (std::uint32_t i = 0; i < after.actor.size(); ++i) {
      if (after.actor[i] == actor) expected.push_back(i);
    }
    starts.push_back(static_cast<std::uint32_t>(expected.size()));
  }
  EXPECT_EQ(list, expected);
  EXPECT_EQ(first, starts);
  // No particle entered a box: confining moves none.
  Renderer renderer(device_, paper_options());
  renderer.confine(trained.particles, actors, 0.0);
  EXPECT_EQ(trained.particles.download().mean(), after.mean());
}

TEST_F(Densify, WhatIsNotANumberIsDead) {
  GaussianSet set = distinct_set(64);
  const float kNaN = std::numeric_limits<float>::quiet_NaN();
  set.opacity_logit()(3) = kNaN;
  set.mean()(5, 1) = kNaN;
  set.sh(3)(9, 2) = std::numeric_limits<float>::infinity();
  set.log_scale()(63, 0) = -std::numeric_limits<float>::infinity();
  Trained trained(device_, set, std::vector<double>(64, 1.0));
  EXPECT_EQ(trained.relocate(densify_, 0, {.seed = 3}).relocated, 4U);
  EXPECT_TRUE(trained.particles.download().params.allFinite());
}

TEST_F(Densify, NothingHappensWithoutErrorsOrParticles) {
  GaussianSet set = distinct_set(40);
  set.opacity_logit()(3) = logit_of(0.001);
  Trained trained(device_, set, std::vector<double>(40, 0.0));
  EXPECT_EQ(trained.relocate(densify_, 5, {.seed = 3}).grown, 0U);
  EXPECT_EQ(trained.particles.download().params, set.params);
  Buffer<std::uint32_t> words(device_, "words", std::vector<std::uint32_t>(40, 6U));
  densify_.follow(words, 1);
  EXPECT_EQ(words.count(), 40U);
  Trained none(device_, GaussianSet(SetKind::kCamera, 1, 0), {});
  EXPECT_EQ(none.relocate(densify_, 5, {.seed = 3}).grown, 0U);
  // All particles are dead: none can be drawn.
  set.opacity_logit().setConstant(logit_of(0.001));
  Trained dead(device_, set, std::vector<double>(40, 1.0));
  EXPECT_EQ(dead.relocate(densify_, 5, {.seed = 3}).relocated, 0U);
}

TEST_F(Densify, NoiseHasTheCovarianceOfTheParticleAndSparesTheOpaque) {
  constexpr Eigen::Index kCount = 40'000;
  test::SingleParticle one;
  one.scale = {0.1, 0.2, 0.3};
  one.rotation = Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, -2, 0.5).normalized());
  one.opacity = 0.01;
  GaussianSet set(SetKind::kCamera, 0, kCount);
  set.params.rowwise() = test::set_of(SetKind::kCamera, {one}).params.row(0);
  set.opacity_logit().tail(100).setConstant(logit_of(0.5));
  std::vector<std::uint32_t> seen(kCount, 1U);
  for (std::size_t i = 0; i < 100; ++i) seen[i] = 0xffffffffU;
  ParticleBuffers particles(device_, set, Precision::kFloat);
  const Buffer<std::uint32_t> keys(device_, "keys", seen);
  constexpr double kStrength = 3.0;
  densify_.jitter(particles, keys, kStrength, {.seed = 1, .iteration = 2});
  const GaussianSet after = particles.download();
  EXPECT_EQ(after.params.rightCols(after.params.cols() - 3), set.params.rightCols(set.params.cols() - 3));
  const Eigen::MatrixXd moved = (after.mean() - set.mean()).cast<double>();
  EXPECT_TRUE((moved.topRows(100).array() == 0.0).all());
  EXPECT_TRUE((moved.bottomRows(100).array() == 0.0).all());
  const Eigen::MatrixXd live = moved.middleRows(100, kCount - 200);
  const double n = static_cast<double>(live.rows());
  const Eigen::Matrix3d found = live.transpose() * live / n;
  const Eigen::Matrix3d axes = one.rotation.toRotationMatrix();
  const Eigen::Matrix3d covariance =
      axes * one.scale.array().square().matrix().asDiagonal() * axes.transpose();
  const double gate = sigma_of(100.0 * (kDead - one.opacity));
  const Eigen::Matrix3d expected = kStrength * kStrength * gate * gate * covariance * covariance;
  // Five standard deviations of the largest entry; rounding of means of some metres.
  const double tolerance = 5.0 * std::sqrt(2.0 / n) * expected.diagonal().maxCoeff();
  EXPECT_LE((found - expected).cwiseAbs().maxCoeff(), tolerance);
  EXPECT_LE(live.colwise().mean().cwiseAbs().maxCoeff(), 5.0 * std::sqrt(expected.diagonal().maxCoeff() / n));
  // The same key gives the same bits.
  ParticleBuffers again(device_, set, Precision::kFloat);
  densify_.jitter(again, keys, kStrength, {.seed = 1, .iteration = 2});
  EXPECT_EQ(again.download().params, after.params);
}

}  // namespace densify_test
}  // namespace simuli

// Tests levels of detail: few particles that represent many.
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "bench/particles/particle_street.hpp"
#include "host/device/render/levels/levels.hpp"

namespace simuli {
namespace {

/// Returns spheres of 1 cm with opacity 1/2 at these positions.
GaussianSet spheres(const std::vector<Eigen::Vector3f>& places) {
  GaussianSet set(SetKind::kCamera, 1, static_cast<Eigen::Index>(places.size()));
  for (std::size_t k = 0; k < places.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    set.mean().row(i) = places[k].transpose();
    set.log_scale().row(i).setConstant(std::log(0.01F));
    set.rotation()(i, 0) = 1.0F;
    set.sh(0).row(i).setConstant(static_cast<float>(k));
  }
  return set;
}

TEST(DetailLevels, OneStandsForThoseOfACell) {
  // 2 cm apart along x, in one cell of 1/16 m.
  const GaussianSet set = spheres({{0.01F, 0.03F, 0.03F}, {0.03F, 0.03F, 0.03F}, {0.05F, 0.03F, 0.03F}});
  const DetailLevels levels = detail_levels(set);
  ASSERT_EQ(levels.set.size(), 4);
  EXPECT_EQ(levels.set.params.topRows(3), set.params);
  EXPECT_LT((levels.set.mean().row(3) - Eigen::RowVector3f(0.03F, 0.03F, 0.03F)).norm(), 1e-7F);
  EXPECT_NEAR(levels.set.sh(0)(3, 0), 1.0F, 1e-6F);
  // The variance along x: 1 cm squared of each particle, and 2 cm squared times 2/3 of their positions.
  const double longest = std::sqrt(1e-4 + 4e-4 * 2.0 / 3.0);
  Eigen::Vector3f scale = levels.set.log_scale().row(3).transpose().array().exp();
  std::sort(scale.begin(), scale.end());
  EXPECT_NEAR(static_cast<double>(scale(0)), 0.01, 1e-7);
  EXPECT_NEAR(static_cast<double>(scale(1)), 0.01, 1e-7);
  EXPECT_NEAR(static_cast<double>(scale(2)), longest, 1e-7);
  // The opacity is 1/2 over each particle's size, smaller over the whole.
  const double own = 1e-4, whole = (1e-4 + 2.0 * 0.01 * longest) / 3.0;
  const double past = std::pow(1.0 - 0.5 * own / whole, 3.0);
  EXPECT_NEAR(1.0 / (1.0 + std::exp(-static_cast<double>(levels.set.opacity_logit()(3)))), 1.0 - past, 1e-6);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(levels.from_m[i], 0.0F);
    EXPECT_EQ(levels.until_m[i], levels.from_m[3]);
  }
  EXPECT_NEAR(static_cast<double>(levels.from_m[3]), longest, 1e-7);
  EXPECT_EQ(levels.until_m[3], kNeverMerged);
}

TEST(DetailLevels, OwnersAndWhatIsNoNumberStayApart) {
  GaussianSet set = spheres(std::vector<Eigen::Vector3f>(8, {0.03F, 0.03F, 0.03F}));
  set.actor = {0, 0, 0, 1, 1, 1, 2, 2};
  set.opacity_logit()(0) = std::numeric_limits<float>::quiet_NaN();
  set.log_scale()(1, 2) = std::numeric_limits<float>::infinity();
  const DetailLevels levels = detail_levels(set);
  // The background keeps one particle; actor 2 has two, too few for another level. Actor 1 has one
  // representative.
  ASSERT_EQ(levels.set.size(), 9);
  EXPECT_EQ(levels.set.actor, (std::vector<std::uint32_t>{0, 0, 0, 1, 1, 1, 2, 2, 1}));
  for (const std::size_t i : {0, 1, 2, 6, 7, 8}) EXPECT_EQ(levels.until_m[i], kNeverMerged);
  for (const std::size_t i : {3, 4, 5}) EXPECT_LT(levels.until_m[i], 0.02F);
  EXPECT_NEAR(levels.set.sh(0)(8, 0), 4.0F, 1e-5F);
}

TEST(DetailLevels, FewerAreDrawnTheFartherOff) {
  const GaussianSet set = street_particles(SetKind::kLidar, 1, 40'000, 3);
  const DetailLevels levels = detail_levels(set);
  EXPECT_LT(levels.set.size(), set.size() * 3 / 2);
  std::size_t before = levels.from_m.size();
  for (const float footprint_m : {1e-4F, 0.1F, 0.3F, 1.0F, 3.0F, 10.0F, 100.0F}) {
    std::size_t drawn = 0;
    for (std::size_t i = 0; i < levels.from_m.size(); ++i) {
      // All are opaque before the first represented particle starts to fade.
      EXPECT_TRUE(levels.from_m[i] == 0.0F || levels.until_m[i] >= kDetailFade * levels.from_m[i]);
      drawn += levels.from_m[i] <= footprint_m && footprint_m < levels.until_m[i] ? 1U : 0U;
    }
    EXPECT_LE(drawn, before) << footprint_m;
    before = drawn;
    if (footprint_m == 1e-4F) {
      EXPECT_EQ(drawn, static_cast<std::size_t>(set.size()));
    }
  }
  EXPECT_LT(before, 200U);
  EXPECT_GT(before, 0U);
}

}  // namespace
}  // namespace simuli

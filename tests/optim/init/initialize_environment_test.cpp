#include "optim/init/initialize_environment.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "host/core/base/angles.hpp"

namespace simuli {
namespace {

/// Returns the direction of a texel's centre.
Eigen::Vector3f direction_of(int x, int y, int width) {
  const double azimuth = (0.5 - (x + 0.5) / width) * 2.0 * kPi;
  const double elevation = (0.5 - (y + 0.5) / (width / 2)) * kPi;
  return Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth),
                         std::cos(elevation) * std::sin(azimuth),
                         std::sin(elevation))
      .cast<float>();
}

Eigen::Vector3f texel(const EnvironmentMap& map, int x, int y) {
  return Eigen::Map<const Eigen::Vector3f>(map.texels.data() + 3 * (y * map.width + x));
}

TEST(InitializeEnvironment, EveryTexelTakesTheMeanOfItsOwnPatches) {
  constexpr int kWidth = 16;
  std::vector<FarShell::Patch> patches;
  for (int y = 0; y < kWidth / 2; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const Eigen::Vector3f colour(static_cast<float>(x), static_cast<float>(y), 0.5F);
      patches.push_back({direction_of(x, y, kWidth), colour - Eigen::Vector3f(0.25F, 0, 0)});
      patches.push_back({direction_of(x, y, kWidth), colour + Eigen::Vector3f(0.25F, 0, 0)});
    }
  }
  const EnvironmentMap map = environment_of(patches, kWidth);
  ASSERT_EQ(map.height, kWidth / 2);
  ASSERT_EQ(map.texels.size(), 3U * kWidth * kWidth / 2);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      ASSERT_EQ(texel(map, x, y), Eigen::Vector3f(static_cast<float>(x), static_cast<float>(y), 0.5F));
    }
  }
}

TEST(InitializeEnvironment, SmallHolesTakeTheMeanOfTheirBlock) {
  constexpr int kWidth = 256;  // blocks of up to 4 x 4
  const EnvironmentMap map = environment_of(
      {{direction_of(4, 2, kWidth), {1.0F, 0.0F, 0.0F}}, {direction_of(6, 2, kWidth), {0.0F, 0.0F, 1.0F}}},
      kWidth);
  EXPECT_EQ(texel(map, 5, 3),
            Eigen::Vector3f(1.0F, 0.0F, 0.0F));  // its block of 2 x 2 contains only the first
  EXPECT_EQ(texel(map, 5, 1), Eigen::Vector3f(0.5F, 0.0F, 0.5F));  // its block of 4 x 4 contains both
}

TEST(InitializeEnvironment, LargeHolesTakeTheMeanOfTheirElevation) {
  constexpr int kWidth = 16;
  std::vector<FarShell::Patch> patches;  // a band of sky ahead, road below it
  for (int x = 4; x < 12; ++x) {
    patches.push_back({direction_of(x, 3, kWidth), {0.0F, 0.0F, 1.0F}});
    patches.push_back({direction_of(x, 4, kWidth), {0.5F, 0.5F, 0.5F}});
  }
  const EnvironmentMap map = environment_of(patches, kWidth);
  for (int x = 4; x < 12; ++x) {
    for (int y = 0; y < 3; ++y) ASSERT_EQ(texel(map, x, y), Eigen::Vector3f(0.0F, 0.0F, 1.0F));
    for (int y = 5; y < 8; ++y) ASSERT_EQ(texel(map, x, y), Eigen::Vector3f(0.5F, 0.5F, 0.5F));
  }
  EXPECT_EQ(texel(map, 0, 0), Eigen::Vector3f(0.0F, 0.0F, 1.0F));  // also all around
  EXPECT_EQ(texel(map, 15, 7), Eigen::Vector3f(0.5F, 0.5F, 0.5F));
  const EnvironmentMap none = environment_of({}, kWidth);
  for (const float value : none.texels) EXPECT_EQ(value, 0.5F);
}

}  // namespace
}  // namespace simuli

#include "host/core/scene/appearance.hpp"

#include <gtest/gtest.h>

namespace simuli {
namespace {

/// Grids whose every value tells its frame.
ColorGrids numbered(std::vector<ColorGrids::Frame> frames) {
  ColorGrids grids = ColorGrids::identity(2, 3, 4, std::move(frames));
  for (std::size_t i = 0; i < grids.values.size(); ++i) {
    grids.values[i] = static_cast<float>(i / grids.values_per_frame());
  }
  return grids;
}

TEST(ColorGrids, IdentityMapsColoursToThemselves) {
  const ColorGrids grids = ColorGrids::identity(2, 3, 4, {{"front", 0.0}, {"front", 0.1}});
  ASSERT_EQ(grids.values_per_frame(), 2U * 3U * 4U * 12U);
  ASSERT_EQ(grids.values.size(), 2 * grids.values_per_frame());
  for (std::size_t i = 0; i < grids.values.size(); ++i) {
    const std::size_t row = i % 12 / 4, column = i % 4;
    ASSERT_EQ(grids.values[i], row == column ? 1.0F : 0.0F);
  }
}

TEST(ColorGrids, AreInterpolatedBetweenTheCamerasNeighboursInTime) {
  // Not in the order of time, and another camera's frame in between.
  const ColorGrids grids = numbered({{"front", 3.0}, {"front", 1.0}, {"left", 1.5}, {"front", 2.0}});
  const auto at = [&](const char* camera, double time_s) {
    const std::vector<float> values = grids.at(camera, time_s);
    EXPECT_EQ(values.size(), grids.values_per_frame());
    for (const float value : values) EXPECT_EQ(value, values.front());
    return values.front();
  };
  EXPECT_EQ(at("front", 1.0), 1.0F);
  EXPECT_FLOAT_EQ(at("front", 1.25), 1.0F + 0.25F * 2.0F);  // between frames 1 and 3
  EXPECT_FLOAT_EQ(at("front", 2.5), 3.0F + 0.5F * -3.0F);   // between frames 3 and 0
  EXPECT_EQ(at("front", 0.0), 1.0F);
  EXPECT_EQ(at("front", 9.0), 0.0F);
  EXPECT_EQ(at("left", -4.0), 2.0F);
  EXPECT_TRUE(grids.at("rear", 1.0).empty());
}

TEST(ColorGrids, FramesOfTheSameTimeAreNoDivisionByZero) {
  const ColorGrids grids = numbered({{"front", 1.0}, {"front", 1.0}});
  EXPECT_EQ(grids.at("front", 1.0).front(), 0.0F);
}

}  // namespace
}  // namespace simuli

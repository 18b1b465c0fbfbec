#include "host/core/scene/appearance.hpp"

#include <gtest/gtest.h>
#include <numbers>

namespace simuli {
namespace {

Camera pinhole(const std::string& name, double focal_px = 100.0) {
  return {.name = name, .width = 100, .height = 60, .fx = focal_px, .fy = focal_px, .cx = 50.0, .cy = 30.0};
}
Eigen::Quaterniond turned(double angle_rad) {  // to the right
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitY()));
}

/// Returns grids whose values identify their frame.
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
    const std::vector<float> values = grids.at(pinhole(camera), turned(0.3), time_s);
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
}

TEST(ColorGrids, FramesOfTheSameTimeAreNoDivisionByZero) {
  const ColorGrids grids = numbered({{"front", 1.0}, {"front", 1.0}});
  EXPECT_EQ(grids.at(pinhole("front"), turned(0.0), 1.0).front(), 0.0F);
}

/// Camera "front" points along z at 0 s, and 0.1 rad to the right of it at 1 s. Values increase by 1 per
/// vertex to the right, 100 per vertex down, 10 per level, and 1000 per frame.
ColorGrids sloping() {
  ColorGrids grids = ColorGrids::identity(5, 3, 2, {{"front", 0.0}, {"front", 1.0}});
  grids.cameras = {pinhole("front")};
  grids.looks = {turned(0.0), turned(0.1)};
  for (std::size_t i = 0; i < grids.values.size(); ++i) {
    const std::size_t vertex = i / ColorGrids::kMatrix;
    grids.values[i] = static_cast<float>(vertex / 2 % 5 + 100 * (vertex / 10 % 3) + 10 * (vertex % 2) +
                                         1000 * (vertex / 30));
  }
  return grids;
}
float value_at(const ColorGrids& grids, const std::vector<float>& of, int x, int y, int z) {
  return of.at(static_cast<std::size_t>((y * grids.size_x + x) * grids.size_z + z) * ColorGrids::kMatrix);
}

TEST(ColorGrids, OfACameraWithoutAnyAreWhatOthersHaveInItsDirections) {
  const ColorGrids grids = sloping();
  const std::vector<float> same = grids.at(pinhole("other"), turned(0.0), 0.0);
  ASSERT_EQ(same.size(), grids.values_per_frame());
  // Half the view angle: from a quarter to three quarters of the other picture.
  const std::vector<float> narrow = grids.at(pinhole("other", 200.0), turned(0.0), 0.0);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 5; ++x) {
      for (int z = 0; z < 2; ++z) {
        EXPECT_NEAR(value_at(grids, same, x, y, z), x + 100 * y + 10 * z, 1e-4);
        EXPECT_NEAR(value_at(grids, narrow, x, y, z), 1.0 + 0.5 * x + 100 * (0.5 + 0.5 * y) + 10 * z, 1e-4);
      }
    }
  }
  // Half-way through a rotation: half of each neighbour in its own directions; the axis is at 50 +- 100 tan
  // 0.05 px.
  const double off = 100.0 * std::tan(0.05) / 25.0;  // vertices
  const std::vector<float> between = grids.at(pinhole("other"), turned(0.05), 0.5);
  EXPECT_NEAR(
      value_at(grids, between, 2, 1, 0), 0.5 * (2.0 + off) + 0.5 * (1000.0 + 2.0 - off) + 100.0, 1e-3);
}

TEST(ColorGrids, OfACameraWithoutAnyAreMeansWhereNobodyLooks) {
  ColorGrids grids = sloping();
  const auto expect_mean = [&](const std::vector<float>& of, double mean) {
    ASSERT_EQ(of.size(), grids.values_per_frame());
    for (int vertex = 0; vertex < 15; ++vertex) {
      for (int z = 0; z < 2; ++z) {
        EXPECT_NEAR(value_at(grids, of, vertex % 5, vertex / 5, z), mean + 10 * z, 1e-3) << vertex;
      }
    }
  };
  expect_mean(grids.at(pinhole("rear"), turned(std::numbers::pi), 0.0), 2.0 + 100.0);
  expect_mean(grids.at(pinhole("rear"), turned(std::numbers::pi), 0.75), 2.0 + 100.0 + 750.0);
  // Beside a recorded view: overlapping directions have its values, others the mean.
  const std::vector<float> beside = grids.at(pinhole("right"), turned(std::atan(0.5)), 0.0);
  EXPECT_NEAR(value_at(grids, beside, 0, 1, 0), 2.0 + 100.0, 1e-3);
  EXPECT_NEAR(value_at(grids, beside, 2, 1, 0), 4.0 + 100.0, 1e-3);
  EXPECT_NEAR(value_at(grids, beside, 4, 1, 0), 2.0 + 100.0, 1e-3);
  // A camera's only grid applies to all its pictures.
  grids.frames[1].camera = "left";
  grids.cameras.push_back(pinhole("left"));
  expect_mean(grids.at(pinhole("other"), turned(0.0), 0.0), 2.0 + 100.0 + 500.0);
  // The directions of the frames are unknown.
  grids = sloping();
  grids.cameras.clear();
  grids.looks.clear();
  expect_mean(grids.at(pinhole("other"), turned(0.0), 0.25), 2.0 + 100.0 + 250.0);
}

}  // namespace
}  // namespace simuli

#include "optim/init/sky.hpp"

#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace simuli {
namespace sky_test {

constexpr int kWidth = 160, kHeight = 120, kHorizon = 60, kWallColumn = 110, kHouseColumn = 40;

/// Returns a view along x of the world, z up; `turned` about the line of sight.
ImageView view(double turned_rad = 0.0) {
  const Camera camera{"front", kWidth, kHeight, 120.0, 120.0, 80.0, 60.0, ShutterKind::kGlobal};
  Eigen::Matrix3d world_from_camera;
  world_from_camera << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Eigen::Quaterniond roll(Eigen::AngleAxisd(turned_rad, Eigen::Vector3d::UnitZ()));
  const Pose at{Eigen::Quaterniond(world_from_camera) * roll, Eigen::Vector3d::Zero()};
  return {camera, at, at};
}

enum class Shown { kSky, kWire, kHouse, kWall, kRoad };

/// A textured house on the left, a uniform wall as bright as the sky on the right, both higher than the
/// picture, a uniform road, and a wire across the picture.
Shown shown(int column, int row) {
  if (row >= kHorizon) return Shown::kRoad;
  if (column < kHouseColumn) return Shown::kHouse;
  if (column >= kWallColumn + 2) return Shown::kWall;
  if (column >= kWallColumn) return Shown::kHouse;  // the corner of the house
  return row == 20 + column / 20 ? Shown::kWire : Shown::kSky;
}

Image picture() {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> texture(0.1F, 0.5F);
  Image image(kWidth, kHeight, 3);
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      const float lighter = 0.003F * static_cast<float>(row);
      Eigen::Vector3f colour(0.5F + lighter, 0.6F + lighter, 0.8F);
      switch (shown(column, row)) {
        case Shown::kSky:
        case Shown::kWall:
          break;
        case Shown::kWire:
          colour.setConstant(0.1F);
          break;
        case Shown::kHouse:
          colour.setConstant(texture(random));
          break;
        case Shown::kRoad:
          colour = {0.6F, 0.65F, 0.8F};
          break;
      }
      for (int c = 0; c < 3; ++c) image.at(column, row, c) = colour[c];
    }
  }
  return image;
}

/// Returns positions 10 m away in every fourth pixel of the lower quarter of all surfaces.
Eigen::Matrix3Xd returns(bool of_wall) {
  std::vector<Eigen::Vector3d> points;
  for (int row = 3 * kHorizon / 4; row < kHeight; row += 2) {
    for (int column = 0; column < kWidth; column += 2) {
      const Shown there = shown(column, row);
      if (there == Shown::kSky || there == Shown::kWire || (there == Shown::kWall && !of_wall)) continue;
      Eigen::Vector3d origin, direction;
      view().unproject({column + 0.5, row + 0.5}, origin, direction);
      points.emplace_back(origin + 10.0 * direction);
    }
  }
  Eigen::Matrix3Xd out(3, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) out.col(static_cast<Eigen::Index>(i)) = points[i];
  return out;
}

/// Returns the share of this content that is classified as sky.
double share(const SkyMask& sky, Shown what) {
  std::size_t all = 0, reported = 0;
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      if (shown(column, row) != what) continue;
      ++all;
      reported += sky.at(static_cast<std::size_t>(row * kWidth + column)) ? 1U : 0U;
    }
  }
  return static_cast<double>(reported) / static_cast<double>(all);
}

TEST(FindSky, TellsSkyFromAWallOfItsColourByReturns) {
  const SkyMask sky = find_sky(view(), picture(), {returns(true)});
  EXPECT_GT(share(sky, Shown::kSky), 0.97);  // on both sides of the wire
  EXPECT_EQ(share(sky, Shown::kWall), 0.0);
  EXPECT_EQ(share(sky, Shown::kWire), 0.0);
  EXPECT_LT(share(sky, Shown::kHouse), 0.001);
  EXPECT_EQ(share(sky, Shown::kRoad), 0.0);
  // Only the returns distinguish this wall from the sky.
  EXPECT_GT(share(find_sky(view(), picture(), {returns(false)}), Shown::kWall), 0.9);
}

TEST(FindSky, NothingWithoutSweepsOrBelowTheHorizon) {
  EXPECT_TRUE(find_sky(view(), picture(), {}).empty());
  const SkyMask turned = find_sky(view(M_PI), picture(), {Eigen::Matrix3Xd(3, 0)});
  for (const Shown what : {Shown::kSky, Shown::kWall, Shown::kHouse}) EXPECT_EQ(share(turned, what), 0.0);
}

TEST(FindSky, WhatIsHiddenIsNone) {
  Image image = picture();
  for (int row = 0; row < kHorizon; ++row) {
    for (int column = 60; column < 70; ++column) {
      for (int c = 0; c < 3; ++c) image.at(column, row, c) = -1.0F;
    }
  }
  const SkyMask sky = find_sky(view(), image, {returns(true)});
  for (int row = 0; row < kHorizon; ++row) {
    for (int column = 60; column < 70; ++column)
      EXPECT_FALSE(sky.at(Eigen::Vector2d(column + 0.5, row + 0.5)));
  }
  EXPECT_GT(share(sky, Shown::kSky), 0.7);
}

}  // namespace sky_test
}  // namespace simuli

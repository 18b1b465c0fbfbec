#include "optim/init/moving_space.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <vector>

namespace simuli {
namespace {

constexpr double kVoxel_m = 0.1;

/// `count` voxel centres in a row from `first` on.
void add_row(
    PointSet& points, std::vector<bool>& moved, const Eigen::Vector3f& first, int count, bool moves) {
  PointSet row;
  row.position.resize(3, count);
  for (int i = 0; i < count; ++i)
    row.position.col(i) = first + Eigen::Vector3f(0.1F * static_cast<float>(i), 0, 0);
  row.intensity.assign(static_cast<std::size_t>(count), 0.5F);
  points.append(row);
  moved.insert(moved.end(), static_cast<std::size_t>(count), moves);
}

TEST(MovingSpace, HoldsDenseVoxelsThatMovedAndNoOthers) {
  PointSet points;
  std::vector<bool> moved;
  // 0.5 m cells: five voxels of each row lie in one.
  add_row(points, moved, {-10.0F + 0.05F, 0.05F, 0.05F}, 5, true);
  add_row(points, moved, {-10.0F + 0.05F, 0.15F, 0.05F}, 5, true);
  add_row(points, moved, {-10.0F + 0.05F, 0.25F, 0.05F}, 5, false);
  add_row(points, moved, {5.05F, 0.05F, 0.05F}, 5, true);  // too few: leaves
  add_row(points, moved, {8.05F, 0.05F, 0.05F}, 5, true);  // ten, but among more that stayed
  add_row(points, moved, {8.05F, 0.15F, 0.05F}, 5, true);
  for (const float y : {0.25F, 0.35F, 0.45F}) add_row(points, moved, {8.05F, y, 0.05F}, 5, false);
  const MovingSpace space(kVoxel_m, points, moved);
  EXPECT_EQ(space.voxels(), 10U);
  EXPECT_TRUE(space.contains({-9.95, 0.05, 0.05}));
  EXPECT_TRUE(space.contains({-9.91, 0.19, 0.01}));   // anywhere in the voxel
  EXPECT_FALSE(space.contains({-9.95, 0.05, 0.15}));  // the next one
  EXPECT_FALSE(space.contains({-9.95, 0.25, 0.05}));  // stayed
  EXPECT_FALSE(space.contains({5.05, 0.05, 0.05}));
  EXPECT_FALSE(space.contains({8.05, 0.05, 0.05}));
  EXPECT_FALSE(MovingSpace{}.contains({0, 0, 0}));
}

TEST(MovingPixels, AreTheDiscsAroundReturns) {
  const Camera camera{"c", 40, 30, 20.0, 20.0, 20.0, 15.0, ShutterKind::kGlobal};
  const ImageView view(camera, Pose{}, Pose{});
  // 5 m ahead a pixel is 0.25 m wide: 0.5 m are two pixels.
  const std::vector<bool> mask = moving_pixels(view, {{0.0, 0.0, 5.0}, {0.0, 0.0, -5.0}}, 0.5);
  ASSERT_EQ(mask.size(), 1200U);
  const auto at = [&](std::size_t x, std::size_t y) -> bool { return mask[y * 40 + x]; };
  EXPECT_TRUE(at(20, 15));
  EXPECT_TRUE(at(18, 15));
  EXPECT_FALSE(at(17, 15));
  EXPECT_TRUE(at(20, 16));
  EXPECT_FALSE(at(20, 17 + 1));
  EXPECT_FALSE(at(18, 13));  // a corner of the square
  EXPECT_EQ(std::count(mask.begin(), mask.end(), true), 12);
}

}  // namespace
}  // namespace simuli

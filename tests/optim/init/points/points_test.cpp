#include "optim/init/points/points.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <set>

#include "host/core/base/error.hpp"
#include "host/core/base/interruption.hpp"
#include "tests/optim/init/points/point_set.hpp"

namespace simuli {
namespace {

using test::point_set;

constexpr double kMicrometre_m = 1e-6;  // resolution of the voxel sums
// Positions of 10 m in float32, and the square roots of their differences.
constexpr float kFloat_m = 1e-5F;

struct Point {
  Eigen::Vector3d position;
  double intensity;
};

std::vector<Point> random_points(std::size_t count) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> metre(-3.0, 3.0);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<Point> points(count);
  for (Point& p : points) p = {{metre(random), metre(random), metre(random)}, unit(random)};
  return points;
}

PointSet voxelise(const std::vector<Point>& points, double voxel_m) {
  VoxelGrid grid(voxel_m);
  for (const Point& p : points) grid.add(p.position, p.intensity);
  EXPECT_EQ(grid.points(), points.size());
  return grid.averages();
}

TEST(VoxelGrid, AveragesPerVoxelAlsoBelowZero) {
  const PointSet set = voxelise({{{0.01, 0.02, 0.03}, 0.2},
                                 {{0.05, 0.06, 0.09}, 0.4},
                                 {{-0.01, 0.02, 0.03}, 1.0},  // the neighbouring voxel
                                 {{5.0, -7.05, 0.0}, 0.3}},
                                0.1);
  ASSERT_EQ(set.size(), 3U);
  // Sorted by z, y, x.
  EXPECT_LT((set.position.col(0) - Eigen::Vector3f(5.0F, -7.05F, 0.0F)).norm(), kFloat_m);
  EXPECT_LT((set.position.col(1) - Eigen::Vector3f(-0.01F, 0.02F, 0.03F)).norm(), kFloat_m);
  EXPECT_LT((set.position.col(2) - Eigen::Vector3f(0.03F, 0.04F, 0.06F)).norm(), kFloat_m);
  EXPECT_NEAR(set.intensity[2], 0.3F, kMicrometre_m);
}

TEST(VoxelGrid, OrderOfThePointsDoesNotShow) {
  std::vector<Point> points = random_points(20000);
  const PointSet a = voxelise(points, 0.5);
  std::shuffle(points.begin(), points.end(), std::mt19937_64(3));
  const PointSet b = voxelise(points, 0.5);
  EXPECT_EQ(a.size(), 12U * 12U * 12U);
  EXPECT_EQ(a.position, b.position);
  EXPECT_EQ(a.intensity, b.intensity);
}

TEST(VoxelGrid, HearsWhoInterrupts) {
  int looks = 0;
  const std::function<void()> look = [&] { ++looks; };
  const Interruption interruption(look);
  (void)voxelise(random_points(100), 0.5);
  EXPECT_GT(looks, 0);
}

TEST(VoxelGrid, RefusesWhatItCannotHold) {
  EXPECT_THROW(VoxelGrid(0.0), Error);
  EXPECT_THROW(VoxelGrid(std::numeric_limits<double>::quiet_NaN()), Error);
  VoxelGrid grid(0.1);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(grid.add({nan, 0, 0}, 0.5), Error);
  EXPECT_THROW(grid.add({0, 0, 0}, nan), Error);
  EXPECT_THROW(grid.add({2e5, 0, 0}, 0.5), Error);
  EXPECT_NO_THROW(grid.add({1e5, -1e5, 0}, 0.5));
}

TEST(Thin, KeepsExactlyTheLimitSpreadOverAll) {
  const std::vector<std::uint32_t> kept = thin(100000, 10000, 1);
  ASSERT_EQ(kept.size(), 10000U);
  EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
  EXPECT_EQ(std::set<std::uint32_t>(kept.begin(), kept.end()).size(), kept.size());
  for (std::uint32_t tenth = 0; tenth < 10; ++tenth) {
    const auto in_tenth =
        std::count_if(kept.begin(), kept.end(), [&](std::uint32_t i) { return i / 10000 == tenth; });
    // The standard deviation of a uniform choice is 30.
    EXPECT_NEAR(static_cast<double>(in_tenth), 1000.0, 150.0) << tenth;
  }
  EXPECT_EQ(thin(100000, 10000, 1), kept);
  EXPECT_NE(thin(100000, 10000, 2), kept);
  const std::vector<std::uint32_t> fewer = thin(100000, 100, 1);
  EXPECT_TRUE(std::includes(kept.begin(), kept.end(), fewer.begin(), fewer.end()));
}

TEST(Thin, KeepsAllWhenThereIsRoom) {
  EXPECT_EQ(thin(3, 3, 1), (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_TRUE(thin(0, 10, 1).empty());
  EXPECT_TRUE(thin(10, 0, 1).empty());
}

TEST(LocalShapes, FindTheNormalOfATiltedPlane) {
  const Eigen::Vector3f normal = Eigen::Vector3f(1, -2, 3).normalized();
  const Eigen::Vector3f u = normal.unitOrthogonal();
  const Eigen::Vector3f v = normal.cross(u);
  std::vector<Eigen::Vector3f> positions;
  for (int i = 0; i < 100; ++i) {
    for (int j = 0; j < 100; ++j) {
      positions.push_back(0.1F * static_cast<float>(i) * u + 0.1F * static_cast<float>(j) * v);
    }
  }
  const std::vector<LocalShape> shapes = local_shapes(point_set(positions));
  ASSERT_EQ(shapes.size(), positions.size());
  for (const LocalShape& shape : shapes) {
    ASSERT_NEAR(shape.spacing_m, 0.1F, 0.02F);  // at a corner the third neighbour is diagonal
    ASSERT_TRUE(shape.planar);
    ASSERT_GT(std::abs((shape.scene_from_local * Eigen::Vector3f::UnitZ()).dot(normal)), 0.9999F);
    ASSERT_NEAR(shape.scene_from_local.norm(), 1.0F, 1e-5F);
  }
}

TEST(LocalShapes, LinesAndCloudsAreNotPlanes) {
  std::vector<Eigen::Vector3f> line;
  for (int i = 0; i < 50; ++i) line.emplace_back(0.2F * static_cast<float>(i), 1.0F, 2.0F);
  for (const LocalShape& shape : local_shapes(point_set(line))) {
    EXPECT_FALSE(shape.planar);
    EXPECT_EQ(shape.scene_from_local.coeffs(), Eigen::Quaternionf::Identity().coeffs());
  }
  std::vector<Eigen::Vector3f> cube;
  for (int i = 0; i < 1000; ++i) {
    cube.emplace_back(
        static_cast<float>(i % 10), static_cast<float>(i / 10 % 10), static_cast<float>(i / 100));
  }
  const std::vector<LocalShape> shapes = local_shapes(point_set(cube));
  EXPECT_FALSE(shapes[555].planar);  // in the middle, neighbours on all sides
  EXPECT_NEAR(shapes[555].spacing_m, 1.0F, kFloat_m);
}

TEST(LocalShapes, FewPointsAreOrdinaryInput) {
  EXPECT_TRUE(local_shapes(PointSet{}).empty());
  EXPECT_TRUE(std::isinf(local_shapes(point_set({{1, 2, 3}}))[0].spacing_m));
  const std::vector<LocalShape> two = local_shapes(point_set({{0, 0, 0}, {0, 3, 4}}));
  EXPECT_NEAR(two[0].spacing_m, 5.0F, kFloat_m);
  EXPECT_FALSE(two[0].planar);
  // Coincident points have no plane and no spacing, but finite values.
  for (const LocalShape& shape : local_shapes(point_set(std::vector<Eigen::Vector3f>(20, {1, 1, 1})))) {
    EXPECT_EQ(shape.spacing_m, 0.0F);
    EXPECT_FALSE(shape.planar);
  }
}

}  // namespace
}  // namespace simuli

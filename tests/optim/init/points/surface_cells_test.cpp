#include "optim/init/points/surface_cells.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <numeric>
#include <random>

#include "tests/optim/init/points/sampled_surface.hpp"

namespace simuli {
namespace surface_cells_test {

using Eigen::Vector3d;
using test::SampledSurface;

constexpr CellOptions kFar{.voxel_rad = 0.02};
constexpr CellOptions kFlat{.flat_side_m = 0.8, .flat_m = 0.015, .alike = 0.1};

std::size_t points_of(const std::vector<SurfaceCell>& cells) {
  return std::accumulate(
      cells.begin(), cells.end(), std::size_t{0}, [](std::size_t sum, const SurfaceCell& c) {
        return sum + c.points;
      });
}

float widest_m(const std::vector<SurfaceCell>& cells) {
  float out = 0.0F;
  for (const SurfaceCell& c : cells) out = std::max(out, c.side_m);
  return out;
}

TEST(SurfaceCells, GrowWithTheNearestRangeTheyWereSeenFrom) {
  // 0.02 rad are 0.1 m at 5 m, 0.2 at 10, 0.8 at 40: powers of two of a voxel below that.
  for (const auto& [x_m, side_m] : {std::pair(6.05, 0.1F), {11.05, 0.2F}, {19.05, 0.2F}, {41.05, 0.8F}}) {
    SampledSurface wall;
    wall.add_wall(x_m, -1.6, 1.6, -1.6, 1.6);
    const auto cells = surface_cells(wall.points, kFar);
    const double per_side = 3.2 / static_cast<double>(side_m);
    EXPECT_EQ(cells.size(), static_cast<std::size_t>(std::lround(per_side * per_side))) << x_m;
    EXPECT_EQ(points_of(cells), 1024U);
    for (const SurfaceCell& c : cells) ASSERT_FLOAT_EQ(c.side_m, side_m) << x_m;
  }
}

TEST(SurfaceCells, OneNearLookIsEnoughToStaySmall) {
  SampledSurface wall;
  wall.add_wall(41.05, -1.6, 1.6, -1.6, 1.6);
  wall.points.sight[0].range_m = 7.0F;
  const auto cells = surface_cells(wall.points, kFar);
  EXPECT_EQ(std::count_if(cells.begin(), cells.end(), [](const auto& c) { return c.side_m < 0.15F; }), 4);
  EXPECT_EQ(points_of(cells), 1024U);
  for (const SurfaceCell& c : cells) {
    if (c.side_m > 0.15F) {
      EXPECT_GT(c.sight.range_m, 41.0F);
    }
  }
}

TEST(SurfaceCells, WithoutSightsNothingGrowsByRange) {
  SampledSurface wall;
  wall.add_wall(41.05, -1.6, 1.6, -1.6, 1.6);
  wall.points.sight.clear();
  EXPECT_EQ(surface_cells(wall.points, kFar).size(), 1024U);
  EXPECT_EQ(widest_m(surface_cells(wall.points, kFlat)), 0.8F);  // flat surfaces have larger cells
}

TEST(SurfaceCells, OfAFlatAlikeWallAreLargeInItsMiddleAndSmallAtItsRim) {
  SampledSurface wall;
  wall.add_wall(4.05, -1.6, 1.6, -1.6, 1.6);
  const auto cells = surface_cells(wall.points, kFlat);
  EXPECT_EQ(points_of(cells), 1024U);
  EXPECT_LT(cells.size(), 400U);
  std::size_t largest = 0;
  for (const SurfaceCell& c : cells) {
    EXPECT_NEAR(c.mean.x(), 4.05F, 1e-5F);
    // Its particle does not extend beyond the wall.
    if (c.side_m > 0.15F) {
      EXPECT_LE(c.mean.tail<2>().cwiseAbs().maxCoeff() + 0.6F * c.side_m, 1.6F);
    }
    if (c.side_m < 0.7F) continue;
    ++largest;
    EXPECT_EQ(c.points, 64U);
    EXPECT_NEAR(c.covariance(1, 1), (0.64 - 0.01) / 12.0, 1e-4);
  }
  EXPECT_EQ(largest, 4U);
  CellOptions none = kFlat;
  none.flat_side_m = 0.0;
  EXPECT_EQ(surface_cells(wall.points, none).size(), 1024U);
}

TEST(SurfaceCells, EndWhereAnotherMaterialBegins) {
  SampledSurface wall;
  wall.add_wall(4.05, -1.6, 0.3, -1.6, 1.6, 0.2);
  wall.add_wall(4.05, 0.3, 1.6, -1.6, 1.6, 0.8);
  const auto cells = surface_cells(wall.points, kFlat);
  EXPECT_LT(cells.size(), 700U);
  for (const SurfaceCell& c : cells) {
    EXPECT_TRUE(std::abs(c.intensity - 0.2F) < 1e-5F || std::abs(c.intensity - 0.8F) < 1e-5F) << c.intensity;
    if (c.side_m > 0.15F) {
      EXPECT_GE(std::abs(c.mean.y() - 0.3F), 0.6F * c.side_m);
    }
  }
}

TEST(SurfaceCells, DontRoundOffCorners) {
  SampledSurface corner;
  corner.add_wall(4.05, 0.0, 1.6, -1.6, 1.6);
  for (int i = 0; i < 16; ++i) {
    for (int j = -16; j < 16; ++j) corner.add({4.15 + 0.1 * i, 0.05, 0.1 * j + 0.05});
  }
  const auto cells = surface_cells(corner.points, kFlat);
  EXPECT_LT(cells.size(), 700U);  // of 1024
  for (const SurfaceCell& c : cells) {
    if (c.points == 1) continue;
    const bool on_wall = std::abs(c.mean.x() - 4.05F) < 0.01F,
               on_other = std::abs(c.mean.y() - 0.05F) < 0.01F;
    EXPECT_TRUE(on_wall || on_other) << c.mean.transpose();
  }
}

TEST(SurfaceCells, LeavePolesFencesAndRimsAsTheyAre) {
  SampledSurface pole;
  for (int j = 0; j < 40; ++j) pole.add({4.05, 0.05, 0.1 * j + 0.05});
  EXPECT_EQ(surface_cells(pole.points, kFlat).size(), 40U);
  // A third of a plane: rays pass through the other two thirds.
  SampledSurface fence;
  for (int i = 0; i < 24; ++i) {
    for (int j = i % 3; j < 24; j += 3) fence.add({4.05, 0.1 * i + 0.05, 0.1 * j + 0.05});
  }
  EXPECT_EQ(widest_m(surface_cells(fence.points, kFlat)), 0.1F);
  // A strip of one voxel along a cell's side does not represent the complete cell.
  SampledSurface strip;
  strip.add_wall(4.05, 0.0, 1.6, 0.0, 0.1);
  EXPECT_EQ(surface_cells(strip.points, kFlat).size(), 16U);
}

TEST(SurfaceCells, TakeTheGapsThatTheSensorLeavesForCovered) {
  // A row every 0.3 m: the density of beams of 0.06 rad at 5 m, but holes for a sensor with more beams.
  SampledSurface sparse;
  sparse.row_rad = 0.06;
  sparse.add_wall(5.05, -1.6, 1.6, -1.6, 1.6, 0.5, 3);
  EXPECT_EQ(widest_m(surface_cells(sparse.points, kFlat)), 0.8F);
  SampledSurface dense;
  dense.add_wall(5.05, -1.6, 1.6, -1.6, 1.6, 0.5, 3);
  EXPECT_LT(widest_m(surface_cells(dense.points, kFlat)), 0.8F);
}

TEST(SurfaceCells, DontDependOnTheOrderOfThePoints) {
  SampledSurface wall;
  wall.add_wall(11.05, -1.6, 0.3, -1.6, 1.6, 0.2);
  wall.add_wall(13.07, -0.4, 1.6, -1.6, 1.6, 0.8);
  CellOptions both = kFlat;
  both.voxel_rad = 0.02;
  const auto expected = surface_cells(wall.points, both);
  std::vector<std::uint32_t> order(wall.points.size());
  std::iota(order.begin(), order.end(), 0U);
  std::mt19937 random(3);
  std::shuffle(order.begin(), order.end(), random);
  const auto found = surface_cells(wall.points.subset(order), both);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].mean, expected[i].mean);
    EXPECT_EQ(found[i].covariance, expected[i].covariance);
    EXPECT_EQ(found[i].intensity, expected[i].intensity);
    EXPECT_EQ(found[i].sight.range_m, expected[i].sight.range_m);
  }
}

TEST(SurfaceCells, OfNothingAreNone) {
  EXPECT_TRUE(surface_cells({}, kFlat).empty());
  SampledSurface one;
  one.add({-3.0, 2.0, 1.0});
  const auto cells = surface_cells(one.points, kFlat);
  ASSERT_EQ(cells.size(), 1U);
  EXPECT_FLOAT_EQ(cells[0].side_m, 0.1F);
  EXPECT_TRUE(cells[0].covariance.isZero(1e-9F));
}

}  // namespace surface_cells_test
}  // namespace simuli

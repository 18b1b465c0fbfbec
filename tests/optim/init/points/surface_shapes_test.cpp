#include "optim/init/points/surface_shapes.hpp"

#include <algorithm>
#include <gtest/gtest.h>

#include "tests/optim/init/points/sampled_surface.hpp"

namespace simuli {
namespace {

using Eigen::Vector3f;
using test::SampledSurface;

constexpr ShapeOptions kShape{};
constexpr CellOptions kEachPoint{};

/// Returns the standard deviation along a direction of the scene, m.
float along(const SurfaceShape& shape, const Vector3f& direction) {
  const Vector3f local = shape.scene_from_local.conjugate() * direction;
  return local.cwiseProduct(shape.scale_m).norm();
}

struct Shaped {
  std::vector<SurfaceCell> cells;
  std::vector<SurfaceShape> shapes;
};
Shaped shaped(const PointSet& points, const CellOptions& options = kEachPoint) {
  Shaped out;
  out.cells = surface_cells(points, options);
  out.shapes = surface_shapes(points, out.cells, kShape);
  return out;
}

TEST(SurfaceShapes, OfADenseWallAreFlatAndAsWideAsTheirVoxels) {
  SampledSurface wall;
  wall.add_wall(5.05, -1.6, 1.6, -1.6, 1.6);
  for (const SurfaceShape& s : shaped(wall.points).shapes) {
    ASSERT_TRUE(s.planar);
    ASSERT_NEAR(along(s, Vector3f::UnitY()), 0.05F, 1e-4F);
    ASSERT_NEAR(along(s, Vector3f::UnitZ()), 0.05F, 1e-4F);
    ASSERT_NEAR(along(s, Vector3f::UnitX()), 0.01F, 1e-4F);
    ASSERT_NEAR(s.scene_from_local.norm(), 1.0F, 1e-5F);
  }
}

TEST(SurfaceShapes, ReachFromRowToRowAndNotFromColumnToColumn) {
  // Beams 0.4 m apart, as for 0.08 rad at 5 m; columns one voxel apart.
  SampledSurface wall;
  wall.row_rad = 0.08;
  wall.add_wall(5.05, -2.0, 2.0, -2.0, 2.0, 0.5, 4);
  const Shaped found = shaped(wall.points);
  for (std::size_t i = 0; i < found.cells.size(); ++i) {
    if (found.cells[i].mean.tail<2>().cwiseAbs().maxCoeff() > 1.0F) continue;
    ASSERT_TRUE(found.shapes[i].planar);
    ASSERT_NEAR(along(found.shapes[i], Vector3f::UnitZ()), 0.2F, 0.01F);
    ASSERT_NEAR(along(found.shapes[i], Vector3f::UnitY()), 0.05F, 0.01F);
    ASSERT_NEAR(along(found.shapes[i], Vector3f::UnitX()), 0.01F, 0.002F);
  }
}

TEST(SurfaceShapes, LeaveOpenWhatIsWiderThanASweepLeavesIt) {
  // Two bands of wall with a gap of 1 m, rows every 0.1 m from the two sights of a sweep.
  SampledSurface bands;
  bands.row_rad = 0.04;
  bands.add_wall(5.05, -2.0, 2.0, 0.0, 1.0);
  bands.add_wall(5.05, -2.0, 2.0, 2.0, 3.0);
  for (const SurfaceShape& s : shaped(bands.points).shapes) EXPECT_LT(along(s, Vector3f::UnitZ()), 0.06F);
}

TEST(SurfaceShapes, OfAPoleDontReachBesideIt) {
  SampledSurface pole;
  pole.row_rad = 0.04;
  for (int j = 0; j < 20; ++j) pole.add({5.05, 0.05, 0.2 * j + 0.05});
  const Shaped found = shaped(pole.points);
  for (std::size_t i = 0; i < found.shapes.size(); ++i) {
    // Also at its ends at most one and a half times the gap between a sweep's beams.
    const float most_m = static_cast<float>(kShape.scale) * 1.5F * 0.04F * found.cells[i].mean.norm();
    EXPECT_LE(along(found.shapes[i], Vector3f::UnitY()), most_m + 1e-4F);
  }
}

TEST(SurfaceShapes, OfMergedCellsCoverThem) {
  SampledSurface wall;
  wall.add_wall(5.05, -1.6, 1.6, -1.6, 1.6);
  const Shaped found = shaped(wall.points, {.flat_side_m = 0.8, .flat_m = 0.015, .alike = 0.1});
  std::size_t merged = 0;
  for (std::size_t i = 0; i < found.cells.size(); ++i) {
    const SurfaceShape& s = found.shapes[i];
    merged += found.cells[i].points > 1 ? 1 : 0;
    EXPECT_NEAR(along(s, Vector3f::UnitY()), 0.5F * found.cells[i].side_m, 0.01F);
    EXPECT_NEAR(along(s, Vector3f::UnitZ()), 0.5F * found.cells[i].side_m, 0.01F);
    EXPECT_NEAR(along(s, Vector3f::UnitX()), 0.01F, 1e-4F);
  }
  EXPECT_GT(merged, 10U);
}

TEST(SurfaceShapes, WithoutSightsReachToTheirNeighbours) {
  SampledSurface wall;
  wall.voxel_m = 0.3;
  wall.add_wall(5.05, -2.1, 2.1, -2.1, 2.1);
  wall.points.sight.clear();
  const Shaped found = shaped(wall.points);
  for (std::size_t i = 0; i < found.cells.size(); ++i) {
    // The third neighbour of corners is diagonal.
    if (found.cells[i].mean.tail<2>().cwiseAbs().minCoeff() > 1.8F) continue;
    EXPECT_NEAR(along(found.shapes[i], Vector3f::UnitY()), 0.15F, 0.01F);
    EXPECT_NEAR(along(found.shapes[i], Vector3f::UnitX()), 0.01F, 1e-4F);
  }
}

TEST(SurfaceShapes, OfWhatIsNoPlaneAreRoundAndAloneNoWiderThanTheirRays) {
  SampledSurface bush;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      for (int k = 0; k < 6; ++k) bush.add({9.05 + 0.1 * i, 0.1 * j + 0.05, 0.1 * k + 0.05});
    }
  }
  bush.add({20.0, 5.0, 3.0});  // a bird
  const Shaped found = shaped(bush.points);
  for (std::size_t i = 0; i < found.cells.size(); ++i) {
    const Vector3f scale = found.shapes[i].scale_m;
    if (found.cells[i].mean.x() > 15.0F) {
      EXPECT_LT(scale.maxCoeff(), 0.15F);
    } else if ((found.cells[i].mean - Vector3f(9.3F, 0.3F, 0.3F)).cwiseAbs().maxCoeff() < 0.1F) {
      EXPECT_NEAR(scale.maxCoeff(), scale.minCoeff(), 0.02F);
    }
  }
}

}  // namespace
}  // namespace simuli

// Tests walls above the LiDAR's field of view: their extrapolation, the evidence in pictures, and the
// street's ground truth.
#include "optim/init/initialize_walls.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "host/core/scene/actor.hpp"
#include "io/base/temporary.hpp"
#include "io/synth/street.hpp"
#include "optim/init/posed_frames.hpp"

namespace simuli {
namespace {

using Colour = std::optional<Eigen::Vector3f>;

Colour grey(float value) { return Eigen::Vector3f::Constant(value); }

TEST(WallColumns, StandOnWhatIsUpright) {
  VoxelGrid grid(0.1);
  for (double x = 0.0; x < 4.0; x += 0.05) {
    for (double z = 0.0; z < 3.0; z += 0.05) grid.add({x, 7.03, z}, 0.5);               // a wall
    for (double y = -4.0; y < 6.0; y += 0.05) grid.add({x, y, -0.02 - 0.02 * x}, 0.5);  // a road
  }
  const std::vector<WallColumn> columns = wall_columns(grid.averages(), 0.2);
  EXPECT_GE(columns.size(), 19U);
  EXPECT_LE(columns.size(), 21U);
  for (const WallColumn& column : columns) {
    EXPECT_NEAR(column.position_m.y(), 7.03, 0.03);
    EXPECT_NEAR(std::abs(column.normal.y()), 1.0, 0.02);
    EXPECT_NEAR(column.top_m, 2.97, 0.1);
  }
}

TEST(WallObservations, AgreeWhereMostDo) {
  WallObservations looks;
  looks.add(10.0F, *grey(0.50F));
  looks.add(11.0F, *grey(0.52F));
  EXPECT_FALSE(looks.agreed());  // too few
  looks.add(12.0F, *grey(0.54F));
  ASSERT_TRUE(looks.agreed());
  EXPECT_NEAR(looks.agreed()->x(), 0.52F, 0.003F);
  looks.add(13.0F, *grey(0.9F));  // an occluder in front
  EXPECT_TRUE(looks.agreed());
  looks.add(14.0F, *grey(0.1F));
  EXPECT_FALSE(looks.agreed());
  for (int i = 0; i < 6; ++i) looks.add(5.0F, *grey(0.2F));  // the nearest views are kept
  ASSERT_TRUE(looks.agreed());
  EXPECT_NEAR(looks.agreed()->x(), 0.2F, 0.003F);
  for (int i = 0; i < 4; ++i) looks.refute();
  EXPECT_TRUE(looks.agreed());
  looks.refute();
  EXPECT_FALSE(looks.agreed());
}

TEST(WallSteps, EndAtTheHighestEdge) {
  EXPECT_EQ(wall_steps({}, 2), 0U);
  EXPECT_EQ(wall_steps({grey(0.5F), grey(0.5F), grey(0.5F)}, 2), 0U);  // uniform: may be the sky
  EXPECT_EQ(wall_steps({grey(0.5F), grey(0.5F), grey(0.8F), grey(0.8F)}, 2), 2U);
  EXPECT_EQ(wall_steps({grey(0.5F), grey(0.8F), {}, {}, grey(0.5F), grey(0.2F)}, 2), 5U);
  EXPECT_EQ(wall_steps({grey(0.5F), grey(0.8F), {}, {}, {}, grey(0.5F), grey(0.2F)}, 2), 1U);
}

/// Returns the horizontal distance from the true facade of the street, from 0.6 m in front of it; none
/// without a facade.
std::optional<double> off_facade_m(const Street& street, const Eigen::Vector3d& p) {
  const double side = p.y() > 0.0 ? 1.0 : -1.0;
  const StreetHit hit = street.trace({p.x(), p.y() - 0.6 * side, p.z()}, {0.0, side, 0.0}, 0.0, 1.2);
  if (!hit.hit) return std::nullopt;
  return std::abs(hit.range - 0.6);
}

TEST(WallsAbove, AreWhereTheStreetHasFacades) {
  const ScratchFolder folder("simuli_walls");
  StreetOptions options;
  options.output = folder.path() / "street.log";
  options.frames = 8;
  options.image_width = 200;
  options.image_height = 112;
  options.lidar_columns = 400;
  options.moving_car = false;
  const Log log = synth_street(options);
  const Eigen::Vector3d origin = scene_origin(log.world_from_rig);

  VoxelGrid grid(0.1);
  for (const SweepFrame& frame : log.sweeps) {
    const PosedSweep posed = load_sweep(log, frame, origin);
    for (std::size_t i = 0; i < posed.sweep.range.size(); ++i) {
      if (posed.sweep.range[i] == 0.0F) continue;
      const Pose pose = interpolate(
          posed.scene_from_lidar_start, posed.scene_from_lidar_end, posed.sweep.rays.time_fraction[i]);
      const Eigen::Vector3d direction =
          Lidar::direction(posed.sweep.rays.azimuth[i], posed.sweep.rays.elevation[i]);
      grid.add(pose * Eigen::Vector3d(ray_origin(posed.lidar, posed.sweep.rays, i) +
                                      static_cast<double>(posed.sweep.range[i]) * direction),
               posed.sweep.intensity[i]);
    }
  }
  PointSet points = grid.averages();
  const std::size_t met = points.size();
  std::vector<const ImageFrame*> images;
  for (const ImageFrame& image : log.images) images.push_back(&image);
  const ActorPoints actors({}, {}, origin);
  std::size_t steps = 0;
  const std::size_t added =
      WallsAbove{log, images, origin, 1.0, 0.1, actors}.add_to(points, [&steps] { ++steps; });

  EXPECT_EQ(steps, images.size());
  ASSERT_EQ(points.size(), met + added);
  EXPECT_GT(added, 2000U);  // 80 m2
  const Street street(options.contents());
  std::size_t right = 0, high = 0;
  for (std::size_t i = met; i < points.size(); ++i) {
    const Eigen::Vector3d p = origin + points.position.col(static_cast<Eigen::Index>(i)).cast<double>();
    const std::optional<double> off_m = off_facade_m(street, p);
    right += off_m && *off_m < 0.15 ? 1U : 0U;
    high += p.z() > 6.0 ? 1U : 0U;
  }
  EXPECT_GT(static_cast<double>(right), 0.9 * static_cast<double>(added));
  EXPECT_GT(high, added / 4);  // not only directly above the LiDAR's field of view
}

}  // namespace
}  // namespace simuli

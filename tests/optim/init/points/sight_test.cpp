#include "optim/init/points/sight.hpp"

#include <gtest/gtest.h>
#include <numbers>

namespace simuli {
namespace {

Lidar spinning() {
  Lidar lidar = builtin_lidar("generic64");
  lidar.columns = 900;
  return lidar;
}

TEST(Sight, StepsAreThoseFromRayToRay) {
  const Lidar lidar = spinning();
  const LidarRays rays = nominal_rays(lidar);
  const SightMaker maker(lidar);
  const std::size_t row = 30, column = 100, ray = row * 900 + column;
  const Eigen::Quaterniond turned(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
  const Sight sight = maker.of(rays, ray, 12.0F, turned);
  const auto direction = [&](std::size_t i) {
    return Eigen::Vector3f((turned * Lidar::direction(rays.azimuth[i], rays.elevation[i])).cast<float>());
  };
  EXPECT_EQ(sight.range_m, 12.0F);
  EXPECT_LT((sight.towards - direction(ray)).norm(), 1e-6F);
  const Eigen::Vector3f next = direction(ray + 1) - direction(ray),
                        above = direction(ray - 900) - direction(ray);
  EXPECT_NEAR(std::abs(sight.column_step.normalized().dot(next.normalized())), 1.0F, 1e-3F);
  EXPECT_NEAR(sight.column_step.norm(), next.norm(), 0.01F * next.norm());
  EXPECT_NEAR(std::abs(sight.row_step.normalized().dot(above.normalized())), 1.0F, 1e-2F);
  EXPECT_NEAR(sight.row_step.norm(), above.norm(), 0.1F * above.norm());
  EXPECT_NEAR(sight.towards.dot(sight.row_step), 0.0F, 1e-6F);
}

TEST(Sight, StepsOnAPlaneLieInItWhereTheNextRaysMeetIt) {
  // Grazing ground: a beam 1 degree higher hits it farther away.
  const double below = -10.0 * std::numbers::pi / 180.0, step = 0.1 * std::numbers::pi / 180.0;
  const Eigen::Vector3f ground = Eigen::Vector3f::UnitZ();
  const double height = 1.7;
  const auto meets = [&](double elevation, double azimuth) {
    const Eigen::Vector3d d = Lidar::direction(azimuth, elevation);
    return Eigen::Vector3d(d * (-height / d.z()));
  };
  const Eigen::Vector3d p = meets(below, 0.0);
  const Eigen::Vector3d d = p.normalized();
  const Sight sight{static_cast<float>(p.norm()),
                    d.cast<float>(),
                    Eigen::Vector3f(0, static_cast<float>(step * std::cos(below)), 0),
                    (step * d.cross(Eigen::Vector3d::UnitY())).cast<float>()};
  const Eigen::Vector3f row = sight.row_step_on(ground);
  EXPECT_NEAR(row.z(), 0.0F, 1e-5F);
  EXPECT_LT((row - (meets(below + step, 0.0) - p).cast<float>()).norm(), 0.02F * row.norm());
  const Eigen::Vector3f column = sight.column_step_on(ground);
  EXPECT_LT((column - (meets(below, step) - p).cast<float>()).norm(), 0.01F * column.norm());
}

TEST(Sight, OfAVoxelIsTheNearestWhateverCameFirst) {
  const Sight near{5.0F, Eigen::Vector3f::UnitX()}, far{9.0F, Eigen::Vector3f::UnitY()};
  EXPECT_TRUE(is_nearer(near, far));
  EXPECT_FALSE(is_nearer(far, near));
  EXPECT_FALSE(is_nearer(near, near));
  EXPECT_TRUE(is_nearer(far, Sight{}));
  EXPECT_FALSE(Sight{}.is_known());
}

TEST(Sight, OfAListIsThatOfItsRaysOnAverage) {
  RayList list;
  list.name = "list";
  for (int i = 0; i < 40; ++i) {
    for (int j = 0; j < 20; ++j) {
      list.azimuth.push_back(0.02 * i);
      list.elevation.push_back(0.02 * j - 0.2);
      list.time_fraction.push_back(0.5);
    }
  }
  const Sight sight =
      SightMaker(list).of(nominal_rays(LidarModel(list)), 123, 3.0F, Eigen::Quaterniond::Identity());
  EXPECT_NEAR(sight.column_step.norm(), 0.02F, 0.001F);
  EXPECT_NEAR(sight.row_step.norm(), 0.02F, 0.001F);
}

}  // namespace
}  // namespace simuli

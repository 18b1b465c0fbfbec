#include <gtest/gtest.h>

#include "host/core/scene/edit.hpp"

namespace simuli {
namespace {

/// Returns one background particle and one particle a metre ahead in each of two cars. The first car drives
/// along y, rotated to the left; the second exists from 10 s on.
Scene two_cars() {
  Scene scene;
  scene.origin = {1000.0, 2000.0, 0.0};
  scene.camera = GaussianSet(SetKind::kCamera, 1, 3);
  scene.camera.rotation().col(0).setOnes();
  scene.camera.mean() << 5.0F, 6.0F, 7.0F, 1.0F, 0.0F, 0.0F, 1.0F, 0.0F, 0.0F;
  scene.camera.actor = {0, 2, 1};
  scene.camera.sh(3).row(2) << 1.0F, 1.0F, 1.0F;  // along x
  Actor car{"car", "car", {4.0, 2.0, 1.5}, {}};
  const Eigen::Quaterniond left(Eigen::AngleAxisd(M_PI / 2.0, Eigen::Vector3d::UnitZ()));
  for (const double time_s : {0.0, 2.0}) {
    car.track.push_back({time_s, {left, {1000.0, 2000.0 + 10.0 * time_s, 0.5}}});
  }
  Actor late = car;
  late.name = "late";
  for (KeyPose& key : late.track) key.time_s += 10.0;
  scene.actors = {car, late};
  return scene;
}

TEST(Moment, PutsActorsWhereTheyAre) {
  const Scene scene = two_cars();
  EXPECT_EQ(background_of(scene, SetKind::kCamera).size(), 1);
  const GaussianSet set = moment_of(scene, SetKind::kCamera, 1.0);
  ASSERT_EQ(set.size(), 2);
  EXPECT_TRUE(set.actor.empty());
  EXPECT_EQ(Eigen::RowVector3f(set.mean().row(0)), Eigen::RowVector3f(5.0F, 6.0F, 7.0F));
  EXPECT_TRUE(Eigen::RowVector3f(set.mean().row(1)).isApprox(Eigen::RowVector3f(0.0F, 11.0F, 0.5F), 1e-6F));
  // The colour from ahead of the car is now the colour from +y.
  EXPECT_NEAR(set.sh(1)(1, 0), 1.0F, 1e-6F);
  EXPECT_NEAR(set.sh(3)(1, 0), 0.0F, 1e-6F);
  EXPECT_EQ(moment_of(scene, SetKind::kCamera, 5.0).size(), 1);
  EXPECT_EQ(moment_of(scene, SetKind::kCamera, 11.0).size(), 2);
}

TEST(Moment, HasTheShapesOfThen) {
  Scene scene = two_cars();
  Deformation& shape = scene.actors[0].deformation;
  shape.nodes = {2, 2, 2};
  shape.interval_s = 1.0;
  for (int knot = 0; knot < 5; ++knot) {
    for (int node = 0; node < 8; ++node)
      shape.offsets_m.insert(shape.offsets_m.end(), {0.1 * knot, 0.0, -0.2});
  }
  // A metre ahead and 0.1 m more: the car points along +y.
  const GaussianSet set = moment_of(scene, SetKind::kCamera, 1.0);
  EXPECT_TRUE(Eigen::RowVector3f(set.mean().row(1)).isApprox(Eigen::RowVector3f(0.0F, 11.1F, 0.3F), 1e-6F));
}

}  // namespace
}  // namespace simuli

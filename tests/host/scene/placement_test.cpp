#include "host/core/scene/placement.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "host/core/scene/edit.hpp"
#include "tests/host/expect_error.hpp"
#include "tests/support/reference.hpp"

namespace simuli {
namespace {

using Eigen::Vector3d;

GaussianSet some_set(int degree, Eigen::Index count) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  GaussianSet set(SetKind::kCamera, degree, count);
  for (Eigen::Index i = 0; i < set.params.size(); ++i) set.params.data()[i] = unit(random);
  return set;
}

Eigen::Matrix3d covariance(const GaussianSet& set, Eigen::Index i) {
  const Eigen::RowVector4d q = set.rotation().row(i).cast<double>();
  const Eigen::Matrix3d turn = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
  const Vector3d scale = set.log_scale().row(i).transpose().cast<double>().array().exp();
  return turn * scale.cwiseAbs2().asDiagonal() * turn.transpose();
}

Vector3d colour(const GaussianSet& set, Eigen::Index i, const Vector3d& towards) {
  const Eigen::VectorXd basis = reference::sh_basis(set.sh_degree, towards);
  Vector3d out = Vector3d::Zero();
  for (int k = 0; k < basis.size(); ++k) out += basis[k] * set.sh(k).row(i).transpose().cast<double>();
  return out;
}

TEST(Placement, MovesTurnsAndScalesAllOfAParticle) {
  const Pose b_from_a{Eigen::Quaterniond(0.3, -0.5, 0.7, 0.2).normalized(), {3.0, -2.0, 1.0}};
  const Eigen::Matrix3d turn = b_from_a.rotation.toRotationMatrix();
  for (const int degree : {0, 1, 2, 3}) {
    const GaussianSet a = some_set(degree, 20);
    GaussianSet b = a;
    transform(b, b_from_a, 2.5);
    for (Eigen::Index i = 0; i < a.size(); ++i) {
      const Vector3d mean = a.mean().row(i).transpose().cast<double>();
      EXPECT_LT((b.mean().row(i).transpose().cast<double>() - b_from_a * (2.5 * mean)).norm(), 1e-5);
      EXPECT_LT((covariance(b, i) - 2.5 * 2.5 * turn * covariance(a, i) * turn.transpose()).norm(), 1e-4);
      for (const Vector3d& d : {Vector3d(1, 0, 0), Vector3d(-0.6, 0.0, 0.8), Vector3d(0.48, -0.6, 0.64)}) {
        EXPECT_LT((colour(b, i, turn * d) - colour(a, i, d)).norm(), 1e-5) << degree;
      }
    }
  }
  GaussianSet set = some_set(0, 1);
  expect_error(ErrorKind::kUsage, "found 0", [&] { transform(set, {}, 0.0); });
}

TEST(Placement, ExtentLeavesOutStraysAndFog) {
  GaussianSet set(SetKind::kCamera, 0, 1000);
  for (Eigen::Index i = 0; i < set.size(); ++i) set.mean().row(i).setConstant(0.001F * static_cast<float>(i));
  set.mean().row(7) << 500.0F, -500.0F, 500.0F;  // one in a thousand
  for (Eigen::Index i = 500; i < 600; ++i) {
    set.mean().row(i).setConstant(80.0F);
    set.opacity_logit()(i) = -5.0F;
  }
  const Eigen::AlignedBox3d box = extent_of(set);
  EXPECT_NEAR(box.min().x(), 0.0, 0.01);
  EXPECT_NEAR(box.max().z(), 1.0, 0.01);
  EXPECT_TRUE(extent_of(GaussianSet(SetKind::kCamera, 0, 0)).isEmpty());
}

TEST(Placement, LidarsSeeTheGeometryOfACameraSet) {
  GaussianSet camera = some_set(2, 3);
  camera.sh(0).row(1).setConstant(0.25F / kSh0);  // a colour of 0.75
  const GaussianSet lidar = lidar_of(camera);
  EXPECT_EQ(lidar.kind, SetKind::kLidar);
  EXPECT_EQ(lidar.params.leftCols(kShRow), camera.params.leftCols(kShRow));
  EXPECT_NEAR(0.5F + kSh0 * lidar.sh(0)(1, 0), 0.75F, 1e-6F);
  EXPECT_GT(kSh0 * lidar.sh(0)(1, 1), 1.0F);
  EXPECT_LT(kSh0 * lidar.sh(0)(1, 2), -1.0F);
}

TEST(Placement, AnObjectStandsOnItsBase) {
  Scene object;
  object.camera = GaussianSet(SetKind::kCamera, 0, 3);
  object.camera.mean() << 1, 1, 5, 3, 2, 6, 2, 1.5F, 9;
  object.camera.actor = {0, 0, 1};
  object.lidar = lidar_of(object.camera);
  Scene scene;
  add_actor(
      scene, as_actor(object, "statue", {Eigen::Quaterniond::Identity(), {10, 20, 30}}), "statue", "two");
  ASSERT_EQ(scene.actors.size(), 1U);
  EXPECT_EQ(scene.actors[0].name, "two");
  EXPECT_TRUE(scene.actors[0].size_m.isApprox(Vector3d(2, 1, 1)));
  EXPECT_TRUE(scene.actors[0].is_there(3600.0));
  EXPECT_TRUE(scene.actors[0].at(12.0).translation.isApprox(Vector3d(10, 20, 30.5)));
  ASSERT_EQ(scene.camera.size(), 2);  // without the actor's particles
  EXPECT_EQ(scene.camera.mean().row(0), Eigen::RowVector3f(-1.0F, -0.5F, -0.5F));
  EXPECT_EQ(scene.lidar.size(), 2);
  expect_error(ErrorKind::kInput, "particles", [] { (void)as_actor(Scene{}, "x", {}); });
}

}  // namespace
}  // namespace simuli

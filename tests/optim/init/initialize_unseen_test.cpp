#include "optim/init/initialize_unseen.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace simuli {
namespace {

/// 100 x 80 px at the origin, looking along +x, the picture's right towards -y: 0.5 m to each side per m.
ImageView view() {
  const Camera camera{"front", 100, 80, 100.0, 100.0, 50.0, 40.0, ShutterKind::kGlobal};
  Eigen::Matrix3d scene_from_camera;
  scene_from_camera << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Pose pose{Eigen::Quaterniond(scene_from_camera), Eigen::Vector3d::Zero()};
  return {camera, pose, pose};
}

struct Points {
  PointSet points;
  std::vector<PointLook> looks;

  void add(const Eigen::Vector3f& position, float intensity) {
    PointSet one;
    one.position = position;
    one.intensity = {intensity};
    points.append(one);
    looks.emplace_back();
  }
  void add_seen(const Eigen::Vector3f& position, float intensity, const Eigen::Vector3f& colour) {
    add(position, intensity);
    looks.back() = {position.norm(), 0.01F * position.norm(), colour};
  }
};

TEST(UnseenPoints, AreThoseThatAMoveToTheSideOrUpBringsIntoThePicture) {
  Points some;
  some.add_seen({10, 0, 0}, 0.5F, {0.2F, 0.4F, 0.6F});
  some.add({10, 0, -1}, 0.5F);  // in the picture, hidden by something
  some.add({10, 7, 0}, 0.5F);   // 2 m to the left of it
  some.add({10, -7, 0}, 0.5F);  // and to the right
  some.add({10, 0, 6}, 0.5F);   // and above
  some.add({10, 9, 0}, 0.5F);   // too far to the left
  some.add({10, 0, -6}, 0.5F);  // below: no camera sinks into the road
  some.add({-10, 0, 0}, 0.5F);  // behind
  const UnseenPoints unseen = unseen_points(some.points, some.looks, {view()}, 3.0);
  ASSERT_EQ(unseen.points.size(), 4U);
  EXPECT_EQ(unseen.points.position, some.points.position.middleCols(1, 4));
  for (const PointLook& look : unseen.looks) {
    EXPECT_LT((look.colour - Eigen::Vector3f(0.2F, 0.4F, 0.6F)).norm(), 1e-6F);
    EXPECT_GE(look.range_m, 10.0F);
    EXPECT_FLOAT_EQ(look.footprint_m, 0.01F * look.range_m);
  }
  EXPECT_EQ(unseen_points(some.points, some.looks, {view()}, 0.0).points.size(), 0U);
}

TEST(UnseenPoints, HaveTheColourOfWhatIsNearAndReflectsAlike) {
  Points some;
  some.add_seen({10, 0, 0}, 0.1F, {0, 0, 0});     // asphalt
  some.add_seen({10, 0.3F, 0}, 0.9F, {1, 1, 1});  // a marking
  some.add({10, 0.1F, 0}, 0.9F);                  // nearer to the asphalt, as bright as the marking
  some.add({10, 0.2F, 0}, 0.1F);
  const UnseenPoints unseen = unseen_points(some.points, some.looks, {view()}, 1.0);
  ASSERT_EQ(unseen.points.size(), 2U);
  EXPECT_GT(unseen.looks[0].colour.minCoeff(), 0.95F);
  EXPECT_LT(unseen.looks[1].colour.maxCoeff(), 0.05F);
}

TEST(UnseenPoints, HaveTheColourOfASurfaceThatFacesAlike) {
  // A pavement goes on behind a parked car; its red rear is much nearer than what pictures show of the
  // pavement.
  Points some;
  const Eigen::Vector3f red{0.6F, 0.1F, 0.1F}, grey{0.5F, 0.5F, 0.5F};
  for (int i = 0; i < 8; ++i) {
    for (int k = 0; k < 8; ++k) {
      const float a = 0.1F * static_cast<float>(i), b = 0.1F * static_cast<float>(k);
      some.add_seen({9, a, b - 1.0F}, 0.5F, red);
      some.add_seen({12.0F + a, b, -1.0F}, 0.5F, grey);
      some.add({9.3F + a, b, -1.0F}, 0.5F);
    }
  }
  const UnseenPoints unseen = unseen_points(some.points, some.looks, {view()}, 1.0);
  ASSERT_EQ(unseen.points.size(), 64U);
  std::size_t greyish = 0;  // those at a rim have too few neighbours for a plane
  for (const PointLook& look : unseen.looks)
    greyish += (look.colour - grey).norm() < (look.colour - red).norm();
  EXPECT_GE(greyish, 60U);
}

TEST(UnseenPoints, AreNoneWithoutAColourOrAView) {
  Points some;
  some.add({10, 0, 0}, 0.5F);
  EXPECT_EQ(unseen_points(some.points, some.looks, {view()}, 3.0).points.size(), 0U);
  some.add_seen({10, 1, 0}, 0.5F, {1, 1, 1});
  EXPECT_EQ(unseen_points(some.points, some.looks, {}, 3.0).points.size(), 0U);
}

}  // namespace
}  // namespace simuli

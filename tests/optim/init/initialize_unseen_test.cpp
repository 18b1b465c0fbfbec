#include "optim/init/initialize_unseen.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

namespace simuli {
namespace {

/// Returns a view of 100 x 80 px at the origin along +x, its right towards -y: 0.5 m to each side per m.
ImageView view() {
  const Camera camera{"front", 100, 80, 100.0, 100.0, 50.0, 40.0, ShutterKind::kGlobal};
  Eigen::Matrix3d scene_from_camera;
  scene_from_camera << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Pose pose{Eigen::Quaterniond(scene_from_camera), Eigen::Vector3d::Zero()};
  return {camera, pose, pose};
}

constexpr std::uint32_t kViews = 3;

struct Points {
  PointSet points;
  std::vector<PointObservation> looks;

  void add(const Eigen::Vector3f& position, float intensity) {
    PointSet one;
    one.position = position;
    one.intensity = {intensity};
    points.append(one);
    looks.emplace_back();
  }
  void add_seen(const Eigen::Vector3f& position,
                float intensity,
                const Eigen::Vector3f& colour,
                std::uint32_t images = kViews,
                const Eigen::Vector3f& other_colour = Eigen::Vector3f::Constant(NAN)) {
    add(position, intensity);
    looks.back() = {position.norm(), 0.01F * position.norm(), colour, images, Eigen::AlignedBox3f(colour)};
    if (other_colour.allFinite()) looks.back().colours.extend(other_colour);
  }
  [[nodiscard]] UnseenSurfaces unseen(double off_path_m, std::size_t views = kViews) const {
    InitOptions options;
    options.off_path_m = off_path_m;
    return unseen_surfaces(points, looks, std::vector<ImageView>(views, view()), options);
  }
};

TEST(UnseenSurfaces, AreThoseThatAMoveToTheSideOrUpBringsIntoThePicture) {
  Points some;
  some.add_seen({10, 0, 0}, 0.5F, {0.2F, 0.4F, 0.6F});
  some.add({10, 0, -1}, 0.5F);  // in the picture, occluded
  some.add({10, 7, 0}, 0.5F);   // 2 m to the left of the picture
  some.add({10, -7, 0}, 0.5F);  // to the right
  some.add({10, 0, 6}, 0.5F);   // above
  some.add({10, 9, 0}, 0.5F);   // too far to the left
  some.add({10, 0, -6}, 0.5F);  // below: cameras are never below the road
  some.add({-10, 0, 0}, 0.5F);  // behind
  const UnseenSurfaces unseen = some.unseen(3.0);
  EXPECT_EQ(unseen.points, 4U);
  ASSERT_EQ(unseen.cells.size(), 4U);
  ASSERT_EQ(unseen.shapes.size(), 4U);
  for (Eigen::Index i = 1; i < 5; ++i) {
    const Eigen::Vector3f wanted = some.points.position.col(i);
    EXPECT_TRUE(std::any_of(unseen.cells.begin(), unseen.cells.end(), [&](const SurfaceCell& cell) {
      return cell.mean == wanted;
    })) << i;
  }
  for (const Eigen::Vector3f& colour : unseen.colours) {
    EXPECT_LT((colour - Eigen::Vector3f(0.2F, 0.4F, 0.6F)).norm(), 1e-6F);
  }
  EXPECT_EQ(some.unseen(0.0).cells.size(), 0U);
}

TEST(UnseenSurfaces, HaveTheColourOfWhatIsNearAndReflectsAlike) {
  Points some;
  some.add_seen({10, 0, 0}, 0.1F, {0, 0, 0});     // asphalt
  some.add_seen({10, 0.3F, 0}, 0.9F, {1, 1, 1});  // a marking
  some.add({10, 0.1F, 0}, 0.9F);                  // nearer to the asphalt, as bright as the marking
  some.add({10, 0.2F, 0}, 0.1F);
  const UnseenSurfaces unseen = some.unseen(1.0);
  ASSERT_EQ(unseen.cells.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const bool is_marking = unseen.cells[i].intensity > 0.5F;
    EXPECT_NEAR(unseen.colours[i].mean(), is_marking ? 1.0F : 0.0F, 0.05F);
  }
}

TEST(UnseenSurfaces, HaveTheColourOfASurfaceThatFacesAlike) {
  // A pavement continues behind a parked car; its red rear is much nearer than the visible pavement.
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
  const UnseenSurfaces unseen = some.unseen(1.0);
  EXPECT_EQ(unseen.points, 64U);
  ASSERT_GE(unseen.cells.size(), 9U);
  std::size_t greyish = 0;  // particles at an edge have too few neighbours for a plane
  for (const Eigen::Vector3f& colour : unseen.colours) {
    greyish += (colour - grey).norm() < (colour - red).norm();
  }
  EXPECT_GE(10 * greyish, 9 * unseen.colours.size());
}

TEST(UnseenSurfaces, AreClosed) {
  // A row of returns every 0.4 m: no picture trains these particles to close the gaps, so each is made as
  // wide as the gaps.
  Points some;
  some.add_seen({8, 0, -1}, 0.5F, {0.5F, 0.5F, 0.5F});
  for (int i = 0; i < 8; ++i) {
    for (int k = 0; k < 20; ++k) {
      some.add({10.05F + 0.4F * static_cast<float>(i), 0.1F * static_cast<float>(k) - 0.95F, -1.0F}, 0.5F);
    }
  }
  some.points.sight.resize(some.points.size());
  for (std::size_t i = 1; i < some.points.size(); ++i) {
    const Eigen::Vector3f p = some.points.position.col(static_cast<Eigen::Index>(i));
    const Eigen::Vector3f d = p.normalized();
    const auto step_to = [&](const Eigen::Vector3f& next) -> Eigen::Vector3f {
      return next.normalized() - next.normalized().dot(d) * d;
    };
    some.points.sight[i] = {p.norm(),
                            d,
                            step_to(p + 0.1F * Eigen::Vector3f::UnitY()),
                            step_to(p + 0.4F * Eigen::Vector3f::UnitX())};
  }
  const UnseenSurfaces unseen = some.unseen(1.0);
  ASSERT_GE(unseen.cells.size(), 80U);
  std::size_t wide = 0;
  for (const SurfaceShape& shape : unseen.shapes) {
    wide += shape.planar && shape.scale_m.maxCoeff() > 0.6F * 0.4F && shape.scale_m.minCoeff() < 0.02F;
  }
  EXPECT_GE(10 * wide, 9 * unseen.shapes.size());
}

TEST(UnseenSurfaces, TakeNoColourFromWhatIsHardlySeen) {
  Points some;
  const Eigen::Vector3f red{0.6F, 0.1F, 0.1F}, grey{0.5F, 0.5F, 0.5F};
  some.add_seen(
      {10, 0.1F, -1}, 0.5F, red, kViews - 1);  // visible past a red rear, between two rows of returns
  some.add_seen({10, 0.2F, -1}, 0.5F, red, kViews, grey);
  some.add_seen({14, 0, -1}, 0.5F, grey, kViews, {0.6F, 0.6F, 0.6F});
  some.add({10, 0, -1}, 0.5F);
  ASSERT_EQ(some.unseen(1.0).colours.size(), 1U);
  EXPECT_LT((some.unseen(1.0).colours[0] - grey).norm(), 1e-6F);
  // With so few pictures, one view in each is the maximum ...
  some.looks[2] = {};
  ASSERT_EQ(some.unseen(1.0, kViews - 1).colours.size(), 2U);
  EXPECT_LT((some.unseen(1.0, kViews - 1).colours[0] - red).norm(), 1e-6F);
  // ... and without better views, a barely visible colour is used.
  some.looks[0] = {};
  ASSERT_EQ(some.unseen(1.0).colours.size(), 3U);
  EXPECT_LT((some.unseen(1.0).colours[0] - red).norm(), 1e-6F);
}

TEST(UnseenSurfaces, AreNoneWithoutAColourOrAView) {
  Points some;
  some.add({10, 0, 0}, 0.5F);
  EXPECT_EQ(some.unseen(3.0).cells.size(), 0U);
  some.add_seen({10, 1, 0}, 0.5F, {1, 1, 1});
  EXPECT_EQ(some.unseen(3.0, 0).cells.size(), 0U);
}

}  // namespace
}  // namespace simuli

#include "optim/init/initialize_views.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "host/core/base/error.hpp"
#include "tests/host/expect_error.hpp"
#include "tests/optim/init/points/point_set.hpp"

namespace simuli {
namespace initialize_views_test {

using test::point_set;

Camera camera(ShutterKind shutter = ShutterKind::kGlobal) {
  return {"front", 100, 80, 100.0, 100.0, 50.0, 40.0, shutter};
}

Image plain(float red, float green, float blue) {
  Image image(100, 80, 3);
  for (std::size_t i = 0; i < image.data.size(); i += 3) {
    image.data[i] = red;
    image.data[i + 1] = green;
    image.data[i + 2] = blue;
  }
  return image;
}

Pose at(double x, double y, double z) { return {Eigen::Quaterniond::Identity(), {x, y, z}}; }

TEST(ImageView, RollingShutterSeesAPointAtItsOwnTime) {
  // Moves 1 m to the right during a readout from top to bottom.
  const ImageView view(camera(ShutterKind::kTopToBottom), at(0, 0, 0), at(1, 0, 0));
  Eigen::Vector2d pixel;
  double range_m = 0.0;
  ASSERT_TRUE(view.project({0.5, 2.0, 10.0}, pixel, range_m));
  EXPECT_NEAR(pixel.y(), 60.0, 1e-6);  // three quarters down, so the camera is at 0.75 m
  EXPECT_NEAR(pixel.x(), 50.0 + 100.0 * (0.5 - 0.75) / 10.0, 1e-6);
  // The ray back through this pixel intersects the point.
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;
  view.unproject(pixel, origin, direction);
  EXPECT_LT((origin + range_m * direction - Eigen::Vector3d(0.5, 2.0, 10.0)).norm(), 1e-6);
}

TEST(ImageView, PointsOutsideThePictureAreNotSeen) {
  const ImageView view(camera(), at(0, 0, 0), at(0, 0, 0));
  Eigen::Vector2d pixel;
  double range_m = 0.0;
  EXPECT_TRUE(view.project({4.9, 0, 10}, pixel, range_m));
  EXPECT_FALSE(view.project({5.1, 0, 10}, pixel, range_m));
  EXPECT_FALSE(view.project({0, 0, -10}, pixel, range_m));
}

TEST(LookAtPoints, TheForegroundHidesTheBackground) {
  std::vector<Eigen::Vector3f> positions;
  for (int i = -5; i <= 5; ++i) {  // a board 1 m wide at 5 m
    for (int j = -5; j <= 5; ++j)
      positions.emplace_back(0.1F * static_cast<float>(i), 0.1F * static_cast<float>(j), 5.0F);
  }
  const std::size_t hidden = positions.size();
  positions.emplace_back(0.12F, 0.12F, 20.0F);  // behind the board
  const std::size_t beside = positions.size();
  positions.emplace_back(6.0F, 0.0F, 20.0F);
  const PointSet points = point_set(positions);
  const ImageView view(camera(), at(0, 0, 0), at(0, 0, 0));
  std::vector<PointObservation> looks(points.size());
  const Coverage coverage = look_at_points(view, plain(0.25F, 0.5F, 0.75F), points, 0.1, 5, looks);
  for (std::size_t i = 0; i < hidden; ++i) ASSERT_TRUE(std::isfinite(looks[i].range_m)) << i;
  EXPECT_TRUE(std::isinf(looks[hidden].range_m));
  ASSERT_TRUE(std::isfinite(looks[beside].range_m));
  EXPECT_NEAR(looks[beside].footprint_m, looks[beside].range_m / 100.0F, 1e-4F);
  EXPECT_LT((looks[beside].colour - Eigen::Vector3f(0.25F, 0.5F, 0.75F)).norm(), 1e-5F);
  EXPECT_EQ(coverage.columns, 20);
  EXPECT_EQ(coverage.rows, 16);
  EXPECT_FALSE(coverage.is_empty_around(10, 8));  // the board
  EXPECT_TRUE(coverage.is_empty_around(0, 0));
}

TEST(LookAtPoints, TheClosestImageGivesTheColour) {
  const PointSet points = point_set({{0, 0, 10}});
  const ImageView far(camera(), at(0, 0, 0), at(0, 0, 0));
  const ImageView near(camera(), at(0, 0, 4), at(0, 0, 4));
  for (const bool near_first : {false, true}) {
    std::vector<PointObservation> looks(1);
    for (const bool is_near : {near_first, !near_first}) {
      (void)look_at_points(
          is_near ? near : far, is_near ? plain(1, 0, 0) : plain(0, 1, 0), points, 0.1, 5, looks);
    }
    EXPECT_EQ(looks[0].range_m, 6.0F);
    EXPECT_EQ(looks[0].colour.x(), 1.0F);
    EXPECT_EQ(looks[0].images, 2U);
    EXPECT_EQ(looks[0].colours.min(), Eigen::Vector3f::Zero());
    EXPECT_EQ(looks[0].colours.max(), Eigen::Vector3f(1, 1, 0));
  }
}

TEST(JoinByFootprint, OnlyWhatNoPictureShowsApartBecomesOne) {
  // Voxels of 0.1 m; 3 px are 0.03 m for the first pair and 0.45 m, so 0.4 m voxels, for the others.
  PointSet points = point_set({{0.05F, 0.05F, 0.05F},
                               {0.15F, 0.05F, 0.05F},
                               {10.05F, 0.05F, 0.05F},
                               {10.25F, 0.15F, 0.05F},
                               {10.45F, 0.05F, 0.05F}});
  points.intensity = {0.1F, 0.2F, 0.3F, 0.5F, 0.9F};
  std::vector<PointObservation> looks(5, {3.0F, 0.01F, {0.2F, 0.4F, 0.6F}});
  for (std::size_t i = 2; i < 5; ++i) looks[i] = {30.0F, 0.15F, {0.5F, 0.5F, 0.5F}};
  looks[3] = {29.0F, 0.145F, {0.7F, 0.5F, 0.1F}};
  EXPECT_EQ(join_by_footprint(points, looks, 0.1, 3.0), 1U);
  ASSERT_EQ(points.size(), 4U);
  ASSERT_EQ(looks.size(), 4U);
  EXPECT_EQ(looks[1].range_m, 3.0F);  // near points are unchanged
  EXPECT_TRUE(points.position.col(1).isApprox(Eigen::Vector3f(0.15F, 0.05F, 0.05F)));
  EXPECT_TRUE(points.position.col(2).isApprox(Eigen::Vector3f(10.15F, 0.1F, 0.05F)));
  EXPECT_NEAR(points.intensity[2], 0.4F, 1e-6F);
  EXPECT_EQ(looks[2].range_m, 29.0F);  // of the nearest view; the colour is the mean of all views
  EXPECT_EQ(looks[2].footprint_m, 0.145F);
  EXPECT_TRUE(looks[2].colour.isApprox(Eigen::Vector3f(0.6F, 0.5F, 0.3F)));
  EXPECT_TRUE(points.position.col(3).isApprox(Eigen::Vector3f(10.45F, 0.05F, 0.05F)));
}

TEST(LookAtPoints, APointCoversAsMuchAsItsDisc) {
  const ImageView view(camera(), at(0, 0, 0), at(0, 0, 0));
  const PointSet points = point_set({{0.005F, 0.005F, 1.0F}, {0.1F, 0.005F, 10.0F}});
  std::vector<PointObservation> looks(points.size());
  const Coverage coverage = look_at_points(view, plain(0, 0, 1), points, 0.1, 1, looks);
  // 0.1 m are 10 px at 1 m, 1 px at 10 m: squares around both pixels.
  const Camera c = camera();
  const int x = c.width / 2, y = c.height / 2;
  const auto is_covered = [&](int column, int row) {
    return coverage.covered[static_cast<std::size_t>(row) * static_cast<std::size_t>(coverage.columns) +
                            static_cast<std::size_t>(column)] == 1;
  };
  EXPECT_TRUE(is_covered(x, y) && is_covered(x - 4, y - 4) && is_covered(x + 4, y + 4));
  EXPECT_FALSE(is_covered(x - 7, y) || is_covered(x, y + 7));
  Coverage whole{1, 200, 100, std::vector<std::uint8_t>(200 * 100, 0)};
  whole.cover({1.0, 1.0}, 1e9);  // not the complete picture
  EXPECT_EQ(whole.covered[33], 1);
  EXPECT_EQ(whole.covered[34], 0);
  EXPECT_EQ(whole.covered[34 * 200], 0);
}

TEST(JoinByFootprint, ZeroPixelsJoinNothingInVoxelsOfTheirOwn) {
  PointSet points = point_set({{0.05F, 0.0F, 0.0F}, {50.15F, 0.0F, 0.0F}, {50.25F, 0.0F, 0.0F}});
  std::vector<PointObservation> looks(3, {50.0F, 5.0F, {0.5F, 0.5F, 0.5F}});
  EXPECT_EQ(join_by_footprint(points, looks, 0.1, 0.0), 0U);
  EXPECT_EQ(points.size(), 3U);
}

TEST(SampleBilinear, PixelCentresAreAtHalves) {
  Image image(2, 1, 3);
  for (int c = 0; c < 3; ++c) image.at(1, 0, c) = 1.0F;
  EXPECT_FLOAT_EQ(sample_bilinear<3>(image, Eigen::Vector2d(0.5, 0.5)).x(), 0.0F);
  EXPECT_FLOAT_EQ(sample_bilinear<3>(image, Eigen::Vector2d(1.0, 0.5)).x(), 0.5F);
  EXPECT_FLOAT_EQ(sample_bilinear<3>(image, Eigen::Vector2d(1.25, 0.2)).y(), 0.75F);
  EXPECT_FLOAT_EQ(sample_bilinear<3>(image, Eigen::Vector2d(2.0, 1.0)).z(), 1.0F);  // the border continues
}

TEST(FarShell, CamerasFarAwayAreRefused) {
  FarShell shell(1.0, 500.0);
  for (const double place : {500.0, 501.0, 1.4e12}) {
    expect_error(ErrorKind::kInput, "allowed less than 500 m", [&] {
      shell.add({{{place, 0.0, 0.0}, Eigen::Vector3d::UnitX(), Eigen::Vector3f::UnitX()}});
    });
  }
}

TEST(FarShell, DirectionsWithinACellBecomeOnePatch) {
  FarShell shell(1.0, 500.0);
  const auto direction = [](double azimuth_deg, double elevation_deg) {
    const double a = azimuth_deg * std::numbers::pi / 180.0;
    const double e = elevation_deg * std::numbers::pi / 180.0;
    return Eigen::Vector3d(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
  };
  const Eigen::Vector3d here = Eigen::Vector3d::Zero();
  shell.add({{here, direction(10.2, 30.4), Eigen::Vector3f::UnitX()},
             {here, direction(10.3, 30.6), Eigen::Vector3f::UnitY()},
             {here, direction(14.0, 30.5), Eigen::Vector3f::UnitZ()}});
  const std::vector<FarShell::Patch> patches = shell.patches(0.5);
  ASSERT_EQ(patches.size(), 2U);
  EXPECT_LT((patches[0].colour - Eigen::Vector3f(0.5F, 0.5F, 0.0F)).norm(), 1e-6F);
  EXPECT_GT(patches[0].direction.dot(direction(10.25, 30.5).cast<float>()), 0.99999F);
}

TEST(FarShell, SeenFromElsewhereThePatchIsWhereTheRayMeetsTheShell) {
  FarShell shell(1.0, 500.0);
  shell.add({{{300, 0, 0}, {0, 1, 0}, Eigen::Vector3f::Ones()}});
  const std::vector<FarShell::Patch> patches = shell.patches(0.5);
  ASSERT_EQ(patches.size(), 1U);
  EXPECT_LT((500.0F * patches[0].direction - Eigen::Vector3f(300, 400, 0)).norm(), 1e-3F);
}

TEST(FarShell, NothingStandsWhereMostLooksMeetSomething) {
  FarShell shell(1.0, 500.0);
  const Eigen::Vector3d here = Eigen::Vector3d::Zero(), seldom(1, 0, 0), often(0, 1, 0), never(0, 0, 1);
  const auto look = [&](int times, const Eigen::Vector3d& way, const std::optional<Eigen::Vector3f>& colour) {
    shell.add(std::vector<FarObservation>(static_cast<std::size_t>(times), {here, way, colour}));
  };
  look(3, seldom, {});
  look(1, seldom, Eigen::Vector3f::UnitZ());
  look(2, often, {});
  look(2, often, Eigen::Vector3f::UnitZ());
  look(1, never, {});
  const std::vector<FarShell::Patch> half = shell.patches(0.5);
  ASSERT_EQ(half.size(), 1U);
  EXPECT_GT(half[0].direction.y(), 0.999F);
  EXPECT_EQ(half[0].colour, Eigen::Vector3f(0, 0, 1));
  EXPECT_EQ(shell.patches(0.0).size(), 2U);
}

TEST(FarShell, AWholeSphereHasCellsOfEqualSizeAndNoDoubles) {
  constexpr double kSpacing_deg = 5.0;
  FarShell shell(kSpacing_deg, 300.0);
  std::vector<FarObservation> looks;
  constexpr int kDirections = 200000;
  for (int i = 0; i < kDirections; ++i) {  // an even spiral
    const double z = 1.0 - 2.0 * (i + 0.5) / kDirections;
    const double a = i * 2.399963229728653;
    const double r = std::sqrt(1.0 - z * z);
    looks.push_back(
        {Eigen::Vector3d::Zero(), {r * std::cos(a), r * std::sin(a), z}, Eigen::Vector3f::Constant(0.5F)});
  }
  shell.add(looks);
  const double spacing = kSpacing_deg * std::numbers::pi / 180.0;
  const double cells = 4.0 * std::numbers::pi / (spacing * spacing);
  // Whole cells per ring: at most one too few of the 72 at the equator, relatively more near the poles.
  EXPECT_NEAR(static_cast<double>(shell.patches(0.5).size()), cells, 0.03 * cells);
}

TEST(FarShell, AddsOnlyWhatNoPointExplains) {
  const ImageView view(camera(), at(0, 0, 0), at(0, 0, 0));
  std::vector<Eigen::Vector3f> wall;  // covers the right half of the picture
  for (int x = 0; x < 60; ++x) {
    for (int y = -45; y < 45; ++y)
      wall.emplace_back(0.1F * static_cast<float>(x), 0.1F * static_cast<float>(y), 10.0F);
  }
  const PointSet points = point_set(wall);
  std::vector<PointObservation> looks(points.size());
  const Image image = plain(0, 0, 1);
  FarShell shell(1.0, 500.0);
  shell.add(far_observations(view, image, look_at_points(view, image, points, 0.1, 2, looks)));
  const std::vector<FarShell::Patch> patches = shell.patches(0.5);
  ASSERT_GT(patches.size(), 100U);
  for (const FarShell::Patch& patch : patches) {
    EXPECT_LT(patch.direction.x(), 0.0F);
    EXPECT_EQ(patch.colour.z(), 1.0F);
  }
}

/// Returns a fisheye of 60 degrees off axis that does not reach the corners of the picture.
Camera narrow_fisheye() {
  Camera fisheye = camera();
  fisheye.lens = Lens(LensKind::kOpencvFisheye, {0.0, 0.0, 0.0, 0.0, std::numbers::pi / 3});
  fisheye.fx = fisheye.fy = 38.0;  // 40 px to the edge of the lens, 64 px to the corner
  return fisheye;
}

TEST(FarShell, LeavesOutPixelsWithoutARay) {
  const ImageView view(narrow_fisheye(), at(0, 0, 0), at(0, 0, 0));
  const PointSet nothing = point_set({});
  std::vector<PointObservation> looks;
  const Image image = plain(0, 0, 1);
  FarShell shell(1.0, 500.0);
  shell.add(far_observations(view, image, look_at_points(view, image, nothing, 0.1, 2, looks)));
  const std::vector<FarShell::Patch> patches = shell.patches(0.5);
  ASSERT_GT(patches.size(), 100U);
  for (const FarShell::Patch& patch : patches) {
    EXPECT_NEAR(patch.direction.norm(), 1.0F, 1e-5F);
    EXPECT_GT(patch.direction.z(), 0.48F);  // 60 degrees off the axis plus a cell
  }
}

TEST(ImageView, PixelSizeIsThatOfTheLens) {
  EXPECT_NEAR(ImageView(camera(), at(0, 0, 0), at(0, 0, 0)).pixel_size_at_1m(), 0.01, 1e-12);
  Camera unified = camera();
  // xi = 1: the picture is half as large as a pinhole's with the same fx.
  unified.lens = Lens(LensKind::kMei, {0.0, 0.0, 0.0, 0.0, 1.0, 1.5});
  const ImageView view(unified, at(0, 0, 0), at(0, 0, 0));
  Eigen::Vector2d here, there;
  double range_m = 0.0;
  ASSERT_TRUE(view.project({0.0, 0.0, 1.0}, here, range_m));
  ASSERT_TRUE(view.project({1e-4, 0.0, 1.0}, there, range_m));
  EXPECT_NEAR((there - here).norm() * view.pixel_size_at_1m(), 1e-4, 1e-8);
}

TEST(FarShell, RefusesSizesThatAreNone) {
  EXPECT_THROW(FarShell(0.0, 500.0), Error);
  EXPECT_THROW(FarShell(1.0, 0.0), Error);
}

TEST(PointBlocks, LeaveOutNothingThatAPictureShows) {
  // Runs of points in all directions, and pictures that rotate and move during their exposure.
  PointSet points;
  points.position.resize(3, 6400);
  std::uint64_t state = 1;
  const auto random = [&state] {
    state = state * 6364136223846793005U + 1442695040888963407U;
    return static_cast<float>(state >> 40U) / static_cast<float>(1U << 24U) - 0.5F;
  };
  for (Eigen::Index k = 0; k < 6400; k += 64) {
    const Eigen::Vector3f from(100.0F * random(), 100.0F * random(), 100.0F * random());
    for (Eigen::Index i = k; i < k + 64; ++i) {
      points.position.col(i) = from + 0.3F * Eigen::Vector3f(static_cast<float>(i - k), random(), random());
      points.intensity.push_back(0.0F);
    }
  }
  const PointBlocks blocks(points);
  for (const ShutterKind shutter : {ShutterKind::kGlobal, ShutterKind::kTopToBottom}) {
    std::size_t shown = 0, looked_at = 0;
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d axis = Eigen::Vector3d(random(), random(), random()).normalized();
      const Pose start{Eigen::Quaterniond(Eigen::AngleAxisd(6.0 * random(), axis)),
                       {20.0 * random(), 20.0 * random(), 0.0}};
      const Pose end{start.rotation * Eigen::Quaterniond(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY())),
                     start.translation + Eigen::Vector3d(1.0, 0.0, 0.5)};
      const ImageView view(camera(shutter), start, end);
      const std::vector<std::uint32_t> seen = blocks.seen_from(view);
      ASSERT_TRUE(std::is_sorted(seen.begin(), seen.end()));
      for (std::uint32_t k = 0; k < 6400; ++k) {
        Eigen::Vector2d pixel;
        double range_m = 0.0;
        if (!view.project(points.position.col(k).cast<double>(), pixel, range_m)) continue;
        ++shown;
        EXPECT_TRUE(std::binary_search(seen.begin(), seen.end(), k)) << k;
      }
      looked_at += seen.size();
      // The same with a maximum distance, and around a position.
      constexpr double kFarthest_m = 30.0;
      const std::vector<std::uint32_t> near = blocks.seen_from(view, kFarthest_m);
      const std::vector<std::uint32_t> around = blocks.within(view.origin(), kFarthest_m);
      EXPECT_TRUE(std::includes(seen.begin(), seen.end(), near.begin(), near.end()));
      EXPECT_TRUE(std::includes(around.begin(), around.end(), near.begin(), near.end()));
      EXPECT_LT(around.size(), 6400U);
      for (std::uint32_t k = 0; k < 6400; ++k) {
        const double away_m = (points.position.col(k).cast<double>() - view.origin()).norm();
        if (away_m > kFarthest_m) continue;
        EXPECT_TRUE(std::binary_search(around.begin(), around.end(), k)) << k;
        EXPECT_EQ(std::binary_search(near.begin(), near.end(), k),
                  std::binary_search(seen.begin(), seen.end(), k))
            << k;
      }
    }
    EXPECT_GT(shown, 0U);
    EXPECT_LT(looked_at, 20U * 6400U / 2);  // most are never tested
  }
}

}  // namespace initialize_views_test
}  // namespace simuli

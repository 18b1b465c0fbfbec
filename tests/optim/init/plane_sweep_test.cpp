#include "optim/init/plane_sweep.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace simuli {
namespace plane_sweep_test {

constexpr double kWall_m = 12.0;

Camera camera() { return {"front", 160, 120, 120.0, 120.0, 80.0, 60.0, ShutterKind::kGlobal}; }

/// Returns a smooth random grey value of a position on the wall.
float texture(double x, double y) {
  const auto at = [](std::int64_t i, std::int64_t j) {
    auto h = static_cast<std::uint64_t>(i * 7919 + j * 104729 + 1000003);
    h = (h ^ (h >> 31U)) * 0x9e3779b97f4a7c15U;
    h = (h ^ (h >> 29U)) * 0xbf58476d1ce4e5b9U;
    return static_cast<float>(h >> 40U) / static_cast<float>(1U << 24U);
  };
  const double u = x / 0.5, v = y / 0.5;  // m per grey value
  const double i = std::floor(u), j = std::floor(v);
  const auto a = static_cast<float>(u - i), b = static_cast<float>(v - j);
  const auto k = static_cast<std::int64_t>(i), l = static_cast<std::int64_t>(j);
  return (1 - b) * ((1 - a) * at(k, l) + a * at(k + 1, l)) +
         b * ((1 - a) * at(k, l + 1) + a * at(k + 1, l + 1));
}

/// Uniform part of the wall, by height over its centre, m.
struct Plain {
  double below_m = 0.0;
};
constexpr Plain kAll{1e9}, kNothing{};

/// Returns a picture of the wall z = kWall_m from a camera at (x, 0, z) along z. `noise`: standard deviation
/// of the grey values, with random numbers from `seed`.
SweepPicture see_wall(double x, Plain plain, double z = 0.0, double noise = 0.0, std::uint32_t seed = 0) {
  const Pose at{Eigen::Quaterniond::Identity(), {x, 0.0, z}};
  const ImageView view(camera(), at, at);
  std::mt19937 random(seed);
  std::normal_distribution<double> off(0.0, std::max(noise, 1e-9));
  Image image(160, 120, 3);
  for (int row = 0; row < 120; ++row) {
    for (int column = 0; column < 160; ++column) {
      const Eigen::Vector3d d = camera().unproject({column + 0.5, row + 0.5});
      const double t = (kWall_m - z) / d.z();
      const bool is_plain = std::abs(t * d.y()) < plain.below_m;
      const float grey = is_plain ? 0.5F : texture(x + t * d.x(), t * d.y());
      const auto value = static_cast<float>(static_cast<double>(grey) + off(random));
      for (int c = 0; c < 3; ++c) image.at(column, row, c) = value;
    }
  }
  return sweep_picture(view, image);
}

Coverage coverage(bool covered) { return {8, 20, 15, std::vector<std::uint8_t>(20 * 15, covered ? 1 : 0)}; }

TEST(SweepDepths, FindsATexturedWall) {
  const SweepPicture left = see_wall(-1.0, kNothing), middle = see_wall(0.0, kNothing),
                     right = see_wall(1.0, kNothing);
  const auto points = sweep_depths(middle, {&left, &right}, coverage(false));
  // One per block of 40 x 30; blocks at the sides are not in both other pictures.
  ASSERT_GT(points.size(), 600U);
  EXPECT_LE(points.size(), 1200U);
  std::size_t near = 0;
  // Steps of inverse distance: 0.0026 / m, 0.37 m at 12 m; the parabola leaves less than half.
  for (const Eigen::Vector3d& p : points) near += std::abs(p.z() - kWall_m) < 0.15 ? 1U : 0U;
  EXPECT_GT(static_cast<double>(near), 0.9 * static_cast<double>(points.size()));
}

TEST(SweepDepths, PlainSurfacesHaveNoDistance) {
  const SweepPicture left = see_wall(-1.0, kAll), middle = see_wall(0.0, kAll), right = see_wall(1.0, kAll);
  EXPECT_TRUE(sweep_depths(middle, {&left, &right}, coverage(false)).empty());
}

/// A band of 1.2 m is 6 pixels high: patches in its middle contain only the band.
TEST(SweepDepths, NarrowPlainSurfacesAreAsFarAsWhatIsAround) {
  constexpr Plain kBand{0.6};
  const SweepPicture left = see_wall(-1.0, kBand), middle = see_wall(0.0, kBand),
                     right = see_wall(1.0, kBand);
  std::size_t in_middle = 0, near = 0;
  for (const Eigen::Vector3d& p : sweep_depths(middle, {&left, &right}, coverage(false))) {
    if (std::abs(p.y()) > 0.15) continue;
    ++in_middle;
    near += std::abs(p.z() - kWall_m) < 0.5 ? 1U : 0U;
  }
  EXPECT_GT(in_middle, 20U);  // of 40 blocks; blocks at the sides are not in both other pictures
  EXPECT_GT(static_cast<double>(near), 0.9 * static_cast<double>(in_middle));
}

/// Pictures of a camera that moves towards the wall.
TEST(SweepDepths, PicturesFarApartMeasureSurfacesAhead) {
  const auto found = [](double step_m) {
    std::vector<SweepPicture> pictures;
    for (int i = -4; i <= 4; ++i) pictures.push_back(see_wall(0.0, kNothing, step_m * i));
    std::vector<const SweepPicture*> others;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      if (i != 4) others.push_back(&pictures[i]);
    }
    std::size_t near = 0;
    for (const Eigen::Vector3d& p : sweep_depths(pictures[4], others, coverage(false))) {
      near += std::abs(p.z() - kWall_m) < 1.5 ? 1U : 0U;
    }
    return near;
  };
  EXPECT_GT(found(0.8), 600U);
  EXPECT_LT(3 * found(0.002), found(0.8));
}

TEST(SweepDepths, NoiseHasNoDistance) {
  std::vector<SweepPicture> pictures;
  for (std::uint32_t i = 0; i < 9; ++i) pictures.push_back(see_wall(0.5 * i - 2.0, kAll, 0.0, 0.02, i));
  std::vector<const SweepPicture*> others;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (i != 4) others.push_back(&pictures[i]);
  }
  EXPECT_LT(sweep_depths(pictures[4], others, coverage(false)).size(), 12U);  // of 1200 blocks
}

TEST(SweepDepths, SkyHasNoDistance) {
  const SweepPicture left = see_wall(-1.0, kNothing), right = see_wall(1.0, kNothing);
  SweepPicture middle = see_wall(0.0, kNothing);
  std::vector<bool> left_half(160 * 120);
  for (std::size_t i = 0; i < left_half.size(); ++i) left_half[i] = i % 160 < 80;
  middle.sky = SkyMask(160, 120, std::move(left_half));
  const auto points = sweep_depths(middle, {&left, &right}, coverage(false));
  EXPECT_GT(points.size(), 300U);
  for (const Eigen::Vector3d& p : points) EXPECT_GT(p.x(), 0.0);
}

TEST(SweepDepths, CoveredCellsAndTooFewPicturesGiveNothing) {
  const SweepPicture left = see_wall(-1.0, kNothing), middle = see_wall(0.0, kNothing),
                     right = see_wall(1.0, kNothing);
  EXPECT_TRUE(sweep_depths(middle, {&left, &right}, coverage(true)).empty());
  EXPECT_TRUE(sweep_depths(middle, {&left}, coverage(false)).empty());
  EXPECT_TRUE(sweep_depths(middle, {}, coverage(false)).empty());
}

}  // namespace plane_sweep_test
}  // namespace simuli

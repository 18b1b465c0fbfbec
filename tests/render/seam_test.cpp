// Tests the cut of a sweep: its azimuth does not matter, and particles at the cut are measured correctly.
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "host/core/base/angles.hpp"
#include "tests/cl/support.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

constexpr double kQuarter = kPi / 2.0;
constexpr int kColumns = 160;  // divisible by four: a quarter revolution is a whole number of columns

/// Returns the transmittance of each ray of a sweep of `lidar` over `set`, row-major.
std::vector<float> sweep(const GaussianSet& set, const Lidar& lidar, const Pose& start, const Pose& end) {
  const Device& device = test::device();
  const RenderOptions options = paper_options();
  Renderer renderer(device, options);
  const SensorRays rays(device, lidar, nominal_rays(lidar), options);
  return renderer.render(ParticleBuffers(device, set, Precision::kFloat), rays, {start, end, {}})
      .results()
      .transmittance;
}

GaussianSet scene() {
  test::SetRecipe recipe;
  recipe.kind = SetKind::kLidar;
  recipe.count = 400;
  recipe.low = {-12, -12, -4};
  recipe.high = {12, 12, 4};
  recipe.scale_min = 0.05;
  recipe.scale_max = 0.8;
  GaussianSet set = test::random_set(recipe, 21);
  set.mean().row(0).setZero();  // one particle surrounds the sensor
  set.log_scale().row(0).setZero();
  return set;
}

TEST(Seam, SweepsAgreeWhereverTheyStart) {
  // At rest: the time of a direction does not matter.
  const GaussianSet set = scene();
  Lidar lidar = test::small_lidar(20, kColumns);
  for (const SpinDirection spin : {SpinDirection::kCounterClockwise, SpinDirection::kClockwise}) {
    lidar.spin = spin;
    lidar.azimuth_first = 0.0;
    const std::vector<float> from_zero = sweep(set, lidar, {}, {});
    for (int quarter = 1; quarter < 4; ++quarter) {
      lidar.azimuth_first = quarter * kQuarter * lidar.spin_sign();
      const std::vector<float> found = sweep(set, lidar, {}, {});
      int clipped = 0;
      for (int row = 0; row < lidar.row_count(); ++row) {
        for (int column = 0; column < kColumns; ++column) {
          const int turned = (column + quarter * kColumns / 4) % kColumns;
          const float a = found[static_cast<std::size_t>(row * kColumns + column)];
          const float b = from_zero[static_cast<std::size_t>(row * kColumns + turned)];
          // Azimuths are floats and boxes have ends: a ray on the edge of a box may be on the other side,
          // which changes it by the clipped tail of one particle.
          clipped += std::abs(a - b) > 1e-4F ? 1 : 0;
          ASSERT_NEAR(a, b, 0.03F) << "quarter " << quarter << " row " << row << " column " << column;
        }
      }
      EXPECT_LE(clipped, 4) << "quarter " << quarter;
    }
  }
}

TEST(Seam, TurningTheSensorFrameChangesNothing) {
  // In motion: the same rays at the same times in the world, with another zero of the azimuths.
  const GaussianSet set = scene();
  Pose start, end;
  end.translation = {1.5, -0.6, 0.1};
  end.rotation = Eigen::AngleAxisd(0.15, Eigen::Vector3d(0.1, 0.0, 1.0).normalized());
  Lidar lidar = test::small_lidar(20, kColumns);
  const std::vector<float> expected = sweep(set, lidar, start, end);
  for (int quarter = 1; quarter < 4; ++quarter) {
    const Pose turn{Eigen::Quaterniond(Eigen::AngleAxisd(quarter * kQuarter, Eigen::Vector3d::UnitZ())),
                    Eigen::Vector3d::Zero()};
    Lidar turned = lidar;
    turned.azimuth_first -= quarter * kQuarter;
    const std::vector<float> found = sweep(set, turned, start * turn, end * turn);
    int clipped = 0;
    for (std::size_t ray = 0; ray < found.size(); ++ray) {
      clipped += std::abs(found[ray] - expected[ray]) > 1e-4F ? 1 : 0;
      ASSERT_NEAR(found[ray], expected[ray], 0.03F) << "quarter " << quarter << " ray " << ray;
    }
    EXPECT_LE(clipped, 4) << "quarter " << quarter;
  }
}

/// Returns the numbers of rays in the first and the last quarter of the sweep that hit a ball behind the
/// sensor, where the sweep starts.
std::pair<int, int> seen_at_both_ends(const Pose& end) {
  test::SingleParticle ball;
  ball.mean = {-10.0, 0.0, -1.3};
  ball.scale = Eigen::Vector3d::Constant(0.3);
  ball.opacity = 0.9;
  const Lidar lidar = test::small_lidar(20, 720);  // from azimuth pi, counter-clockwise
  const std::vector<float> found = sweep(test::set_of(SetKind::kLidar, {ball}), lidar, {}, end);
  std::pair<int, int> seen{0, 0};
  for (std::size_t ray = 0; ray < found.size(); ++ray) {
    const std::size_t column = ray % 720;
    if (!(found[ray] < 0.7F)) continue;
    if (column < 180) ++seen.first;
    if (column >= 540) ++seen.second;
  }
  return seen;
}

TEST(Seam, WhatStandsAtTheCutIsMetAsTheGeometrySays) {
  Pose end;
  // At rest the ball is cut in two: half of it at either end.
  const auto [first_half, last_half] = seen_at_both_ends(end);
  EXPECT_GT(first_half, 0);
  EXPECT_GT(last_half, 0);
  // Yaw with the spin (90 degrees/s): the sweep covers 9 degrees more, and the complete ball a second time.
  end.rotation = Eigen::AngleAxisd(0.157, Eigen::Vector3d::UnitZ());
  const auto [first_yaw, last_yaw] = seen_at_both_ends(end);
  EXPECT_NEAR(first_yaw, first_half, 3);
  EXPECT_GE(last_yaw, 2 * last_half - 3);
  // Yaw against the spin: the sweep ends before the ball.
  end.rotation = Eigen::AngleAxisd(-0.157, Eigen::Vector3d::UnitZ());
  const auto [first_back, last_back] = seen_at_both_ends(end);
  EXPECT_GT(first_back, 0);
  EXPECT_EQ(last_back, 0);
  // A motion of 1 m to the right shows the ball again early, a motion to the left too late.
  end.rotation.setIdentity();
  end.translation = {0.0, -1.0, 0.0};
  EXPECT_GE(seen_at_both_ends(end).second, 2 * last_half - 3);
  end.translation = {0.0, 1.0, 0.0};
  EXPECT_EQ(seen_at_both_ends(end).second, 0);
}

}  // namespace
}  // namespace simuli

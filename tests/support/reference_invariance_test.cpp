// Tests that some changes of the scene do not change renders of the reference.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "host/core/base/angles.hpp"
#include "tests/support/reference.hpp"
#include "tests/support/scenes.hpp"

namespace simuli::reference {
namespace reference_invariance_test {

using Eigen::Vector3d;

constexpr double kDouble = 1e-9;        // roundings of positions of 100 m under exp(-q/2) with small scales
constexpr double kDoubleMargin = 1e-6;  // range keys are single precision: 6e-8 of their value
constexpr double kAzimuth = 2e-3;  // azimuths are single precision: 2e-7 rad, 1e-5 m at 50 m, against 1 cm
constexpr double kAzimuthMargin = 2e-3;
const Vector3d kCameraBackground(0.1, 0.2, 0.3);
const Vector3d kLidarBackground(0.0, -4.0, 4.0);

Particles around_sensor(SetKind kind, int sh_degree, std::uint64_t seed) {
  test::SetRecipe recipe;
  recipe.kind = kind;
  recipe.sh_degree = sh_degree;
  recipe.count = 300;
  recipe.low = {-25.0, -25.0, -5.0};
  recipe.high = {25.0, 25.0, 4.0};
  recipe.scale_min = 0.05;
  recipe.scale_max = 1.5;
  return Particles(test::random_set(recipe, seed));
}

/// scene_from_sensor while driving: about 1 m and 4 degrees per frame.
Pose drive(double u) {
  Pose pose;
  pose.rotation = Eigen::AngleAxisd(0.07 * u + 0.4, Vector3d(0.05, 0.1, 1.0).normalized());
  pose.translation = {0.3 + u, -0.2 + 0.1 * u, 0.1};
  return pose;
}

Sensor moving_camera(ShutterKind shutter) {
  const Pose rig_from_camera = test::forward_from_camera();
  return Sensor::of(
      test::small_camera(32, 24, shutter), drive(0.0) * rig_from_camera, drive(1.0) * rig_from_camera);
}

Lidar offset_lidar() {
  Lidar lidar = test::small_lidar(8, 60);
  lidar.beam_divergence = 2e-3;
  for (std::size_t r = 0; r < lidar.rows.size(); ++r) {
    lidar.rows[r].vertical_offset = 0.1 + 0.01 * static_cast<double>(r);
    lidar.rows[r].horizontal_offset = r % 2 == 0 ? 0.02 : -0.02;
    lidar.rows[r].azimuth_offset = 0.01 * static_cast<double>(r % 3);
  }
  return lidar;
}

Sensor moving_lidar() {
  const Lidar lidar = offset_lidar();
  return Sensor::of(lidar, nominal_rays(lidar), drive(0.0), drive(1.0));
}

/// Compares rays whose decisions do not depend on rounding, and expects that nearly all rays qualify.
void expect_same(const std::vector<RayResult>& a,
                 const std::vector<RayResult>& b,
                 double tolerance,
                 double margin) {
  ASSERT_EQ(a.size(), b.size());
  std::size_t compared = 0;
  int contributors = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!(a[i].margin > margin)) continue;
    ++compared;
    contributors += a[i].contributors;
    EXPECT_EQ(a[i].contributors, b[i].contributors) << "ray " << i;
    EXPECT_NEAR((a[i].feature - b[i].feature).norm(), 0.0, tolerance) << "ray " << i;
    EXPECT_NEAR(a[i].transmittance, b[i].transmittance, tolerance) << "ray " << i;
    EXPECT_NEAR(a[i].distance, b[i].distance, 100.0 * tolerance) << "ray " << i;  // metres up to 80
    if (a[i].median_margin > margin) {
      EXPECT_NEAR(a[i].median_distance, b[i].median_distance, 100.0 * tolerance) << "ray " << i;
    }
  }
  EXPECT_GT(static_cast<double>(compared), 0.8 * static_cast<double>(a.size()));
  EXPECT_GT(contributors, static_cast<int>(a.size())) << "the scene is nearly empty";
}

double difference(const std::vector<RayResult>& a, const std::vector<RayResult>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    largest = std::max(largest, (a[i].feature - b[i].feature).norm());
  return largest;
}

/// Moves the set rigidly. Only degree 0: higher harmonics would need a rotation.
Particles transformed(const Particles& particles, const Pose& new_from_old) {
  Particles out = particles;
  for (Eigen::Index i = 0; i < out.size(); ++i) {
    const Vector3d mean = particles.params.row(i).segment<3>(kMeanRow).transpose();
    const Eigen::Vector4d q = particles.params.row(i).segment<4>(kRotationRow).transpose();
    out.params.row(i).segment<3>(kMeanRow) = (new_from_old * mean).transpose();
    const Eigen::Quaterniond turned = new_from_old.rotation * Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
    out.params.row(i).segment<4>(kRotationRow) << turned.w(), turned.x(), turned.y(), turned.z();
  }
  return out;
}

Pose some_pose() {
  test::Random random(21);
  Pose pose;
  pose.rotation = random.rotation();
  pose.translation = {60.0, -80.0, 20.0};
  return pose;
}

TEST(Invariance, MovingSceneAndCameraTogether) {
  const Particles set = around_sensor(SetKind::kCamera, 0, 1);
  const Pose new_from_old = some_pose();
  const Sensor sensor = moving_camera(ShutterKind::kTopToBottom);
  const Sensor moved = Sensor::of(sensor.camera,
                                  new_from_old * sensor.scene_from_sensor_start,
                                  new_from_old * sensor.scene_from_sensor_end);
  expect_same(render(set, sensor, {}, kCameraBackground),
              render(transformed(set, new_from_old), moved, {}, kCameraBackground),
              kDouble,
              kDoubleMargin);
}

TEST(Invariance, MovingSceneAndLidarTogether) {
  const Particles set = around_sensor(SetKind::kLidar, 0, 2);
  const Pose new_from_old = some_pose();
  const Sensor sensor = moving_lidar();
  const Sensor moved = Sensor::of(sensor.lidar,
                                  sensor.lidar_rays,
                                  new_from_old * sensor.scene_from_sensor_start,
                                  new_from_old * sensor.scene_from_sensor_end);
  expect_same(render(set, sensor, {}, kLidarBackground),
              render(transformed(set, new_from_old), moved, {}, kLidarBackground),
              kDouble,
              kDoubleMargin);
}

TEST(Invariance, TurningTheLidarsFrameUnderItsAzimuths) {
  // The same rays in the world, at the same times, with all azimuths shifted: atan2 and the particles' boxes
  // wrap at another angle.
  const Particles set = around_sensor(SetKind::kLidar, 2, 3);
  const Sensor sensor = moving_lidar();
  const std::vector<RayResult> expected = render(set, sensor, {}, kLidarBackground);
  for (const double turn : {kPi / 2, kPi, -kPi / 2, 1.0}) {
    Pose old_from_turned;
    old_from_turned.rotation = Eigen::AngleAxisd(-turn, Vector3d::UnitZ());
    Lidar lidar = sensor.lidar;
    lidar.azimuth_first += turn;
    const Sensor turned = Sensor::of(lidar,
                                     nominal_rays(lidar),
                                     sensor.scene_from_sensor_start * old_from_turned,
                                     sensor.scene_from_sensor_end * old_from_turned);
    expect_same(expected, render(set, turned, {}, kLidarBackground), kAzimuth, kAzimuthMargin);
  }
}

TEST(Invariance, ShutterOfAStandingCamera) {
  const Particles set = around_sensor(SetKind::kCamera, 3, 4);
  const auto standing = [&](ShutterKind shutter) {
    const Pose pose = drive(0.3) * test::forward_from_camera();
    return render(set, Sensor::of(test::small_camera(32, 24, shutter), pose, pose), {}, kCameraBackground);
  };
  const std::vector<RayResult> global = standing(ShutterKind::kGlobal);
  for (const ShutterKind shutter : {ShutterKind::kTopToBottom,
                                    ShutterKind::kBottomToTop,
                                    ShutterKind::kLeftToRight,
                                    ShutterKind::kRightToLeft}) {
    expect_same(global, standing(shutter), kDouble, kDoubleMargin);
  }
}

TEST(Invariance, ShutterOfAMovingCameraMatters) {
  const Particles set = around_sensor(SetKind::kCamera, 0, 5);
  const std::vector<RayResult> global =
      render(set, moving_camera(ShutterKind::kGlobal), {}, kCameraBackground);
  const std::vector<RayResult> down =
      render(set, moving_camera(ShutterKind::kTopToBottom), {}, kCameraBackground);
  const std::vector<RayResult> up =
      render(set, moving_camera(ShutterKind::kBottomToTop), {}, kCameraBackground);
  EXPECT_GT(difference(global, down), 0.1);
  EXPECT_GT(difference(up, down), 0.1);
}

TEST(Invariance, MotionOfALidarMatters) {
  const Particles set = around_sensor(SetKind::kLidar, 0, 6);
  const Sensor moving = moving_lidar();
  const Pose middle = moving.scene_from_sensor(0.5);
  const Sensor standing = Sensor::of(moving.lidar, moving.lidar_rays, middle, middle);
  EXPECT_GT(
      difference(render(set, moving, {}, kLidarBackground), render(set, standing, {}, kLidarBackground)),
      0.1);
}

TEST(Invariance, OrderOfTheSet) {
  test::SetRecipe recipe;
  recipe.sh_degree = 1;
  recipe.count = 200;
  recipe.scale_max = 1.0;
  const GaussianSet set = test::random_set(recipe, 7);
  const Sensor sensor = moving_camera(ShutterKind::kLeftToRight);
  const std::vector<RayResult> expected = render(Particles(set), sensor, {}, kCameraBackground);
  for (const std::uint64_t seed : {1U, 2U}) {
    const GaussianSet shuffled = test::permuted(set, test::random_order(set.size(), seed));
    const std::vector<RayResult> results = render(Particles(shuffled), sensor, {}, kCameraBackground);
    for (std::size_t i = 0; i < results.size(); ++i) {
      EXPECT_EQ(results[i].feature, expected[i].feature) << "ray " << i;  // the same sums in the same order
      EXPECT_EQ(results[i].distance, expected[i].distance) << "ray " << i;
    }
  }
}

TEST(Invariance, BoxesOnlyTakeAwayFaintContributions) {
  const Particles set = around_sensor(SetKind::kLidar, 0, 8);
  const Sensor sensor = moving_lidar();
  Options unclipped;
  unclipped.ignore_box = true;
  const std::vector<RayResult> clipped = render(set, sensor, {}, kLidarBackground);
  const std::vector<RayResult> whole = render(set, sensor, unclipped, kLidarBackground);
  double lost = 0.0;
  double difference_sum = 0.0;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    const double change = clipped[i].transmittance - whole[i].transmittance;
    lost = std::max(lost, change);
    difference_sum += std::abs(change);
    EXPECT_GE(change, -kDouble) << "ray " << i;  // fewer contributors leave more light
  }
  EXPECT_GT(lost, 0.0) << "no box clipped anything: the option is not tested";
  EXPECT_LT(difference_sum / static_cast<double>(whole.size()), 0.01);
}

TEST(Boxes, ClipEachAxisByItself) {
  for (const SetKind kind : {SetKind::kCamera, SetKind::kLidar}) {
    const Particles set = around_sensor(kind, 0, 12);
    const Sensor sensor = kind == SetKind::kCamera ? moving_camera(ShutterKind::kGlobal) : moving_lidar();
    const std::vector<Ray> all = rays(sensor);
    Options unclipped;
    unclipped.ignore_box = true;
    int outside_x = 0;
    int outside_y = 0;
    for (Eigen::Index k = 0; k < set.size(); ++k) {
      Particles one = set;
      one.params = set.params.row(k);
      const std::vector<Footprint> footprint = project(one, sensor);
      const std::vector<RayResult> whole = render(one, sensor, all, footprint, unclipped, kCameraBackground);
      const std::vector<RayResult> clipped = render(one, sensor, all, footprint, {}, kCameraBackground);
      for (std::size_t i = 0; i < all.size(); ++i) {
        double dx = std::abs(all[i].x - footprint[0].mean.x());
        if (kind == SetKind::kLidar) dx = std::min(dx, std::abs(all[i].x - footprint[0].other_x));
        const bool in_x = dx <= footprint[0].half_width.x();
        // A row of a picture is inside if one row of its block of four is inside.
        bool in_y = false;
        const double first_row = std::floor(all[i].y / 4.0) * 4.0 + 0.5;
        for (int row = 0; row < 4; ++row) {
          const double y = kind == SetKind::kLidar ? all[i].y : first_row + row;
          in_y |= std::abs(y - footprint[0].mean.y()) <= footprint[0].half_width.y();
        }
        EXPECT_EQ(clipped[i].contributors, in_x && in_y ? whole[i].contributors : 0) << "particle " << k;
        if (whole[i].contributors == 1 && !in_x && in_y) ++outside_x;
        if (whole[i].contributors == 1 && in_x && !in_y) ++outside_y;
      }
    }
    EXPECT_GT(outside_x, 0) << "kind " << static_cast<int>(kind);
    EXPECT_GT(outside_y, 0) << "kind " << static_cast<int>(kind);
  }
}

TEST(Scenes, AreTheSameForTheSameSeed) {
  test::SetRecipe recipe;
  recipe.sh_degree = 2;
  const GaussianSet a = test::random_set(recipe, 9);
  EXPECT_EQ(a.params, test::random_set(recipe, 9).params);
  EXPECT_NE(a.params, test::random_set(recipe, 10).params);
  EXPECT_TRUE(a.params.allFinite());
  EXPECT_EQ(a.params.cols(), 11 + 27);
}

}  // namespace reference_invariance_test
}  // namespace simuli::reference

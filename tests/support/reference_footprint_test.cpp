// Boxes of the reference: sizes, fallbacks, levers, time.
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "tests/support/reference.hpp"
#include "tests/support/scenes.hpp"

namespace simuli::reference {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using test::SingleParticle;

constexpr double kDouble = 1e-12;  // roundings of double arithmetic on values around 1
constexpr double kSingle = 2e-6;   // parameters are stored in single precision

SingleParticle small_at(const Vector3d& mean, double scale = 0.01, double opacity = 0.5) {
  SingleParticle particle;
  particle.mean = mean;
  particle.scale.setConstant(scale);
  particle.opacity = opacity;
  return particle;
}

Footprint camera_footprint(const SingleParticle& particle) {
  const Particles set(test::set_of(SetKind::kCamera, {particle}));
  return project(set, Sensor::of(test::small_camera(100, 80), Pose(), Pose()))[0];
}

Footprint lidar_footprint(const SingleParticle& particle, const Lidar& lidar) {
  const Particles set(test::set_of(SetKind::kLidar, {particle}));
  return project(set, Sensor::of(lidar, nominal_rays(lidar), Pose(), Pose()))[0];
}

TEST(CameraFootprint, OfASmallParticleIsItsScaledCovariance) {
  const Footprint f = camera_footprint(small_at({1.0, -0.5, 10.0}));
  const double focal = 60.0;
  const double range2 = 101.25;
  const double variance = 1e-4 + range2 / (12.0 * focal * focal);
  EXPECT_NEAR(f.filter_variance, range2 / (12.0 * focal * focal), kSingle);
  EXPECT_NEAR(f.filtered_scale.x(), std::sqrt(variance), kSingle);
  EXPECT_NEAR(f.mean.x(), 50.0 + 6.0, 0.01);  // the second-order shift is f x s^2 / z^3
  EXPECT_NEAR(f.mean.y(), 40.0 - 3.0, 0.01);
  const double sigma_x_px = focal / 10.0 * std::sqrt(variance * (1.0 + 0.1 * 0.1));
  EXPECT_NEAR(f.half_width.x(), std::sqrt(2.0 * std::log(255.0 * 0.5)) * sigma_x_px, 1e-3 * f.half_width.x());
  EXPECT_NEAR(f.covariance(0, 0), sigma_x_px * sigma_x_px, 1e-3);
  EXPECT_TRUE(f.visible);
  EXPECT_FALSE(f.fallback);
}

TEST(CameraFootprint, FaintParticlesAreDropped) {
  EXPECT_FALSE(camera_footprint(small_at({0, 0, 5}, 0.1, 0.99 / 255.0)).visible);
  EXPECT_TRUE(camera_footprint(small_at({0, 0, 5}, 0.1, 1.01 / 255.0)).visible);
}

TEST(CameraFootprint, FallsBackToTheWholePictureNearTheCamera) {
  const std::vector<SingleParticle> near_or_around = {
      small_at({0.0, 0.0, 0.1}, 1.0),   // the camera is inside
      small_at({0.0, 0.0, -0.5}, 0.5),  // behind, with a sigma point in front
      small_at({0.0, 0.0, -1.2},
               0.5),  // all sigma points behind, but its ball of k s = 1.56 m reaches forward
      small_at({9.0, 0.0, 0.8}, 0.3),  // more than 84 degrees off axis
  };
  for (const SingleParticle& particle : near_or_around) {
    const Footprint f = camera_footprint(particle);
    EXPECT_TRUE(f.visible);
    EXPECT_TRUE(f.fallback);
    EXPECT_EQ(f.mean, Vector2d(50.0, 40.0));
    EXPECT_EQ(f.half_width, Vector2d(50.0, 40.0));
  }
  EXPECT_FALSE(camera_footprint(small_at({0.0, 0.0, -3.0}, 0.5)).visible);
  EXPECT_FALSE(camera_footprint(small_at({0.0, 0.0, 4.0})).fallback);
}

TEST(LidarFootprint, OfASmallParticleIsItsAngularSize) {
  Lidar lidar = test::small_lidar(8, 90);
  lidar.beam_divergence = 3e-3;
  const Footprint f = lidar_footprint(small_at({0.0, 20.0, 0.0}, 0.05), lidar);
  const double beam = 0.25 * std::tan(1.5e-3) * std::tan(1.5e-3) * 400.0;
  EXPECT_NEAR(f.filter_variance, beam, kDouble);
  EXPECT_NEAR(f.mean.x(), spin_angle(lidar, kPi / 2, kPi), kDouble);
  EXPECT_NEAR(f.mean.y(), 0.0, kDouble);
  const double half = std::sqrt(2.0 * std::log(255.0 * 0.5)) * std::sqrt(0.0025 + beam) / 20.0;
  EXPECT_NEAR(f.half_width.x(), half, 1e-4 * half);
  EXPECT_NEAR(f.half_width.y(), half, 1e-4 * half);
}

TEST(LidarFootprint, WidensByTheLeverArm) {
  Lidar lidar = test::small_lidar(3, 90);
  const Footprint plain = lidar_footprint(small_at({20.0, 0.0, 0.4}, 0.05), lidar);
  lidar.rows[0].vertical_offset = 0.5;
  lidar.rows[1].vertical_offset = 0.4;
  lidar.rows[2].vertical_offset = 0.3;
  lidar.rows[1].horizontal_offset = -0.1;
  const Footprint f = lidar_footprint(small_at({20.0, 0.0, 0.4}, 0.05), lidar);
  EXPECT_NEAR(f.mean.y(), 0.0, 1e-7);  // the reference origin is at z = 0.4 m, stored in single precision
  const double lever = 0.1 + 0.1;
  const double range = std::hypot(20.0, 0.4);
  EXPECT_NEAR(f.half_width.x() - plain.half_width.x(), lever / (range - lever), 1e-5);
  EXPECT_NEAR(f.half_width.y() - plain.half_width.y(), lever / (range - lever), 1e-5);
}

TEST(LidarFootprint, IsEverythingAroundTheSensorAndAtThePoles) {
  const Lidar lidar = test::small_lidar(8, 90);
  const Footprint around = lidar_footprint(small_at({0.5, 0.2, 0.0}, 0.5), lidar);
  EXPECT_TRUE(around.fallback);
  EXPECT_GE(around.half_width.x(), kPi);
  EXPECT_GE(around.half_width.y(), kPi);
  const Footprint above = lidar_footprint(small_at({0.1, 0.1, 10.0}, 0.05), lidar);
  EXPECT_TRUE(above.fallback);
  EXPECT_GE(above.half_width.x(), kPi);
  EXPECT_GE(above.half_width.y(), kPi);
  EXPECT_FALSE(lidar_footprint(small_at({5.0, 0.0, 0.0}, 0.05), lidar).fallback);
}

TEST(LidarFootprint, StandsAtBothEndsOfTheSweep) {
  const Lidar lidar = test::small_lidar(8, 90);  // starts at azimuth pi, counter-clockwise
  const auto footprint = [&](const Vector3d& motion) {
    Pose end;
    end.translation = motion;
    const Sensor sensor = Sensor::of(lidar, nominal_rays(lidar), Pose(), end);
    return project(Particles(test::set_of(SetKind::kLidar, {small_at({-10.0, 0.0, 0.0}, 0.4)})), sensor)[0];
  };
  const Footprint still = footprint({0.0, 0.0, 0.0});
  EXPECT_NEAR(std::abs(still.other_x - still.mean.x()), 2.0 * kPi, kDouble);
  // Dead astern at the start. A sensor that goes 1 m to the right meets it again atan(1/10) before the end...
  const Footprint twice = footprint({0.0, -1.0, 0.5});
  EXPECT_NEAR(std::abs(twice.other_x - twice.mean.x()), 2.0 * kPi - std::atan2(1.0, 10.0), 2e-3);
  const double elevation_change = std::atan2(0.5, std::hypot(10.0, 1.0));
  EXPECT_NEAR(twice.half_width.y() - still.half_width.y(), 0.5 * elevation_change, 2e-3);
  // ... and to one that goes to the left the sweep ends before it comes up again.
  const Footprint once = footprint({0.0, 1.0, 0.5});
  EXPECT_EQ(once.other_x, once.mean.x());
  EXPECT_NEAR(once.half_width.y(), still.half_width.y(), 2e-3);
}

/// Expects that a particle on a ray, at the ray's own time, projects to the position of the ray.
void expect_projection_inverts_rays(const Sensor& sensor, double distance_m, double tolerance) {
  const std::vector<Ray> all = rays(sensor);
  std::vector<SingleParticle> particles;
  for (const Ray& ray : all) particles.push_back(small_at(ray.origin + distance_m * ray.direction, 1e-4));
  Options options;
  options.filter_variance_px2 = 0.0;  // the filter shifts the mean, which is not tested here
  const std::vector<Footprint> footprints =
      project(Particles(test::set_of(sensor.kind, particles)), sensor, options);
  for (std::size_t i = 0; i < all.size(); ++i) {
    double dx = footprints[i].mean.x() - all[i].x;
    if (sensor.kind == SetKind::kLidar && std::abs(footprints[i].other_x - all[i].x) < std::abs(dx)) {
      dx = footprints[i].other_x - all[i].x;
    }
    EXPECT_NEAR(dx, 0.0, tolerance) << "ray " << i;
    EXPECT_NEAR(footprints[i].mean.y() - all[i].y, 0.0, tolerance) << "ray " << i;
  }
}

Pose moved(const Vector3d& translation, double yaw_rad) {
  Pose pose;
  pose.rotation = Eigen::AngleAxisd(yaw_rad, Vector3d(0.1, 0.2, 1.0).normalized());
  pose.translation = translation;
  return pose;
}

TEST(Time, ProjectionFindsTheRayThatSeesThePointWithARollingShutter) {
  const Pose start = moved({1.0, 2.0, 0.5}, 0.3) * test::forward_from_camera();
  const Pose end = moved({1.9, 2.1, 0.5}, 0.33) * test::forward_from_camera();
  for (const ShutterKind shutter : {ShutterKind::kGlobal,
                                    ShutterKind::kTopToBottom,
                                    ShutterKind::kBottomToTop,
                                    ShutterKind::kLeftToRight,
                                    ShutterKind::kRightToLeft}) {
    // 0.9 m and 1.7 degrees within the frame: three updates leave less than a fiftieth of a pixel.
    expect_projection_inverts_rays(Sensor::of(test::small_camera(24, 16, shutter), start, end), 15.0, 0.02);
  }
}

TEST(Time, ProjectionFindsTheRayThatSeesThePointWithASpinningLidar) {
  Lidar lidar = test::small_lidar(4, 40);
  for (const SpinDirection spin : {SpinDirection::kCounterClockwise, SpinDirection::kClockwise}) {
    lidar.spin = spin;
    // Inside the sweep: at its ends a point may be measured twice or never.
    LidarRays sweep = nominal_rays(lidar);
    std::vector<std::size_t> inner;
    for (int r = 0; r < 4; ++r) {
      for (int c = 2; c < 38; ++c) inner.push_back(static_cast<std::size_t>(r * 40 + c));
    }
    LidarRays kept{4, 36, {}, {}, {}};
    for (const std::size_t i : inner) {
      kept.azimuth.push_back(sweep.azimuth[i]);
      kept.elevation.push_back(sweep.elevation[i]);
      kept.time_fraction.push_back(sweep.time_fraction[i]);
    }
    const Sensor sensor = Sensor::of(lidar, kept, moved({1.0, 2.0, 0.5}, 0.3), moved({2.5, 2.2, 0.5}, 0.35));
    expect_projection_inverts_rays(sensor, 15.0, 2e-5);  // a hundredth of a typical column
  }
}

TEST(Time, RangesAreThoseOfTheMiddleOfTheFrame) {
  const Particles set(test::set_of(SetKind::kCamera, {small_at({0.0, 0.0, 8.0})}));
  Pose end;
  end.translation = {0.0, 0.0, 4.0};
  EXPECT_NEAR(project(set, Sensor::of(test::small_camera(5, 5), Pose(), end))[0].range, 6.0, kDouble);
}

TEST(Time, SharesOfTheFrameAreClamped) {
  const Camera camera = test::small_camera(20, 10, ShutterKind::kBottomToTop);
  EXPECT_NEAR(exposure_time(camera, {3.0, 2.5}), 0.75, kDouble);
  EXPECT_EQ(exposure_time(camera, {3.0, -50.0}), 1.0);
  EXPECT_EQ(exposure_time(camera, {3.0, 50.0}), 0.0);
  Lidar lidar = test::small_lidar(2, 100);
  lidar.spin = SpinDirection::kClockwise;
  const double half_column = kPi / 100.0;
  EXPECT_NEAR(spin_angle(lidar, kPi, 0.0), half_column, kDouble);
  EXPECT_NEAR(spin_angle(lidar, kPi / 2, kPi), kPi / 2 + half_column, kDouble);
  EXPECT_NEAR(spin_angle(lidar, -kPi / 2, kPi), 1.5 * kPi + half_column, kDouble);
  EXPECT_NEAR(spin_angle(lidar, kPi, 2.0 * kPi), 2.0 * kPi + half_column, kDouble);
}

TEST(Rays, AgreeWithTheSensorModels) {
  const Pose start = moved({1.0, 2.0, 0.5}, 0.3);
  const Pose end = moved({2.5, 2.2, 0.5}, -0.4);
  const Camera camera = test::small_camera(6, 4, ShutterKind::kTopToBottom);
  const std::vector<Ray> pixels = rays(Sensor::of(camera, start, end));
  ASSERT_EQ(pixels.size(), 24U);
  for (const Ray& ray : pixels) {
    const Vector2d pixel(ray.x, ray.y);
    const Pose pose = interpolate(start, end, camera.exposure_fraction(pixel));
    EXPECT_NEAR((ray.origin - pose.translation).norm(), 0.0, kDouble);
    EXPECT_NEAR((ray.direction - pose.rotation * camera.unproject(pixel)).norm(), 0.0, kDouble);
  }
  Lidar lidar = test::small_lidar(3, 5);
  lidar.rows[1] = {
      .elevation = -0.1, .azimuth_offset = 0.02, .vertical_offset = 0.1, .horizontal_offset = 0.03};
  const LidarRays sweep = nominal_rays(lidar);
  const std::vector<Ray> beams = rays(Sensor::of(lidar, sweep, start, end));
  ASSERT_EQ(beams.size(), 15U);
  for (std::size_t i = 0; i < beams.size(); ++i) {
    const Pose pose = interpolate(start, end, sweep.time_fraction[i]);
    const double azimuth = sweep.azimuth[i];
    const Vector3d origin = pose * lidar.origin(static_cast<int>(i / 5), azimuth);
    EXPECT_NEAR((beams[i].origin - origin).norm(), 0.0, kDouble);
    EXPECT_NEAR((beams[i].direction - pose.rotation * Lidar::direction(azimuth, sweep.elevation[i])).norm(),
                0.0,
                kDouble);
  }
}

TEST(Rays, TurnOnTheShorterArc) {
  const Pose start = moved({1.0, 2.0, 0.5}, 0.3);
  const Pose end = moved({2.5, 2.2, 0.5}, -0.4);
  Pose same_end = end;
  same_end.rotation.coeffs() = -end.rotation.coeffs();  // the same rotation by the other quaternion
  const Camera camera = test::small_camera(6, 4, ShutterKind::kLeftToRight);
  const std::vector<Ray> expected = rays(Sensor::of(camera, start, end));
  const std::vector<Ray> same = rays(Sensor::of(camera, start, same_end));
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR((same[i].direction - expected[i].direction).norm(), 0.0, kDouble);
  }
}

TEST(Rays, PointAtTheMeasuredElevationAndStandAtTheNominalOne) {
  const Lidar lidar = test::small_lidar(2, 3);
  LidarRays sweep = nominal_rays(lidar);
  sweep.elevation[4] += 0.01F;  // row 1
  const Ray ray = rays(Sensor::of(lidar, sweep, Pose(), Pose()))[4];
  EXPECT_NEAR(std::asin(ray.direction.z()), static_cast<double>(sweep.elevation[4]), kDouble);
  EXPECT_EQ(ray.y, lidar.rows[1].elevation);
}

TEST(Refusals, NameTheReason) {
  GaussianSet set = test::set_of(SetKind::kCamera, {small_at({0, 0, 5})});
  const Lidar lidar = test::small_lidar(2, 8);
  const Sensor sweep = Sensor::of(lidar, nominal_rays(lidar), Pose(), Pose());
  EXPECT_THROW((void)project(Particles(set), sweep), Error);
  set.rotation().setZero();
  EXPECT_THROW((void)project(Particles(set), Sensor::of(test::small_camera(5, 5), Pose(), Pose())), Error);
  EXPECT_THROW((void)Sensor::of(test::small_lidar(3, 8), nominal_rays(lidar), Pose(), Pose()), Error);
}

}  // namespace
}  // namespace simuli::reference

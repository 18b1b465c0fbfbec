// Tests extent = exact against sums over all particles in double for cases beyond the reference: folding
// lenses, needles, discs, particles around and behind the sensor.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "host/core/base/angles.hpp"
#include "host/core/base/linear_algebra.hpp"
#include "tests/cl/support.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace extent_brute_test {

using Eigen::Vector3d;
using test::Shot;
using test::SingleParticle;

constexpr double kAlphaCut = 1.0 / 255.0;
// A response this close to the cut (in its exponent) may be decided differently in float: needles amplify
// 6e-8 by 100 000.
constexpr double kUndecided = 0.02;
// Relative to the transmittance; a lost contribution changes it by 1/255 or more.
constexpr double kRounding = 2e-3;

struct Decided {
  double transmittance = 1.0;
  std::size_t contributors = 0;
  bool sure = true;
};

/// Returns one ray through all particles.
Decided through(const std::vector<SingleParticle>& particles,
                const Vector3d& o,
                const Vector3d& d,
                double near_m) {
  Decided out;
  for (const SingleParticle& p : particles) {
    const Vector3d inverse = p.scale.cwiseInverse();
    const Vector3d og = inverse.cwiseProduct(p.rotation.conjugate() * (o - p.mean));
    const Vector3d dg = inverse.cwiseProduct(p.rotation.conjugate() * d);
    const double q = og.cross(dg).squaredNorm() / dg.squaredNorm();
    const double tau = -og.dot(dg) / dg.squaredNorm();
    const double above_cut = std::log(p.opacity / kAlphaCut) - 0.5 * q;
    if (tau > near_m - 1e-3 && above_cut > -kUndecided && (above_cut < kUndecided || tau < near_m + 1e-3)) {
      out.sure = false;
    }
    if (!(above_cut >= 0.0 && tau > near_m)) continue;
    out.transmittance *= 1.0 - p.opacity * std::exp(-0.5 * q);
    ++out.contributors;
  }
  return out;
}

/// Expects that the resting rays of `shot` include all contributions.
void expect_nothing_lost(const Shot& shot, const std::vector<SingleParticle>& particles) {
  const Device& device = test::device();
  RenderOptions options;
  options.extent = Extent::kExact;
  options.camera_filter_px2 = 0.0;
  Renderer renderer(device, options);
  const SensorRays rays = shot.on(device, options);
  const RayResults results =
      renderer
          .render(
              ParticleBuffers(device, test::set_of(shot.kind, particles), options.precision), rays, shot.view)
          .results();
  const Pose& scene_from_sensor = shot.view.scene_from_sensor_start;
  std::size_t compared = 0, covered = 0, different = 0;
  double worst = 0.0;
  for (std::size_t i = 0; i < results.rays; ++i) {
    Vector3d origin = Vector3d::Zero(), direction;
    if (shot.kind == SetKind::kCamera) {
      const auto width = static_cast<std::size_t>(shot.camera.width);
      direction =
          shot.camera.unproject({static_cast<double>(i % width) + 0.5, static_cast<double>(i / width) + 0.5});
      if (direction.isZero(0.0)) continue;
    } else {
      direction = Lidar::direction(shot.rays.azimuth[i], shot.rays.elevation[i]);
      origin = ray_origin(shot.lidar, shot.rays, i);
    }
    const Decided expected = through(particles,
                                     scene_from_sensor * origin,
                                     scene_from_sensor.rotation * direction,
                                     shot.kind == SetKind::kCamera ? 0.01 : shot.lidar.range_min);
    if (!expected.sure) continue;
    const double error =
        std::abs(static_cast<double>(results.transmittance[i]) / expected.transmittance - 1.0);
    ++compared;
    covered += expected.contributors > 0 ? 1 : 0;
    different += error <= kRounding ? 0 : 1;
    worst = std::max(worst, error);
  }
  EXPECT_EQ(different, 0U) << "of " << compared << " rays, worst " << worst;
  EXPECT_GT(3 * compared, results.rays);
  EXPECT_GT(10 * covered, compared);
}

Shot camera_of(const std::string& name, int width, int height) {
  Shot shot = test::shot_of({"camera", SetKind::kCamera, false, false, 0}, 16, 16);
  shot.camera = builtin_camera(name).resized(width, height);
  shot.camera.shutter = ShutterKind::kGlobal;
  return shot;
}

/// Returns particles ahead of and around the camera of shot_of, which points along x.
std::vector<SingleParticle> scattered(int count,
                                      double farthest_off_rad,
                                      double largest,
                                      std::uint64_t seed) {
  test::Random random(seed);
  std::vector<SingleParticle> particles;
  for (int i = 0; i < count; ++i) {
    SingleParticle particle;
    const double off = farthest_off_rad * std::sqrt(random.uniform(0.0, 1.0)),
                 turn = random.uniform(-kPi, kPi);
    const double range = std::exp(random.uniform(std::log(1.0), std::log(30.0)));
    particle.mean =
        range * Vector3d(std::cos(off), std::sin(off) * std::cos(turn), std::sin(off) * std::sin(turn));
    particle.rotation = random.rotation();
    const double longest = largest * range * std::exp(random.uniform(-3.0, 0.0));
    for (int axis = 0; axis < 3; ++axis)
      particle.scale[axis] = longest * std::exp(axis == 0 ? 0.0 : random.uniform(std::log(0.05), 0.0));
    particle.opacity = random.uniform(0.01, 0.25);
    particles.push_back(particle);
  }
  return particles;
}

std::size_t pairs_of(const Shot& shot, const std::vector<SingleParticle>& particles, Extent extent) {
  const Device& device = test::device();
  RenderOptions options;
  options.extent = extent;
  Renderer renderer(device, options);
  const SensorRays rays = shot.on(device, options);
  return renderer
      .render(ParticleBuffers(device, test::set_of(shot.kind, particles), options.precision), rays, shot.view)
      .buffers()
      .binned.pairs;
}

// The fold of these two lenses is within the cone of their picture.
TEST(ExactExtentOfFoldedLenses, LosesNothing) {
  for (const char* const name : {"pandaset_back_camera", "pandaset_front_camera"}) {
    SCOPED_TRACE(name);
    const Shot shot = camera_of(name, 96, 54);
    expect_nothing_lost(shot, scattered(200, 1.3, 0.3, 5));
    expect_nothing_lost(shot, scattered(600, 0.9, 0.03, 6));
  }
}

TEST(ExactExtentOfFoldedLenses, TestsNotMuchMoreThanUnscented) {
  for (const char* const name : {"pandaset_back_camera", "pandaset_front_camera"}) {
    const Shot shot = camera_of(name, 640, 360);
    const std::vector<SingleParticle> particles = scattered(3000, 0.9, 0.01, 7);
    const auto exact = static_cast<double>(pairs_of(shot, particles, Extent::kExact));
    const double ratio = exact / static_cast<double>(pairs_of(shot, particles, Extent::kUnscented));
    RecordProperty(name, std::to_string(ratio));
    EXPECT_LT(ratio, 1.3) << name;
  }
}

/// Returns needles and discs of 1 : 10 000 in all directions, balls around the sensor, and long particles
/// that extend from behind the sensor to its front.
std::vector<SingleParticle> degenerate() {
  test::Random random(11);
  std::vector<SingleParticle> particles;
  for (int i = 0; i < 120; ++i) {
    SingleParticle particle;
    particle.rotation = random.rotation();
    particle.opacity = random.uniform(0.02, 0.1);
    const double size = random.uniform(0.1, 1.0);
    particle.mean = random.uniform(1.5, 12.0) * random.direction();
    switch (i % 4) {
      case 0:
        particle.scale = {4.0 * size, 4e-4 * size, 4e-4 * size};
        break;
      case 1:
        particle.scale = {size, size, 1e-4 * size};
        break;
      case 2:  // the sensor is inside in some cases
        particle.mean *= 0.1;
        particle.scale = {size, 2.0 * size, 3.0 * size};
        break;
      default: {  // from behind the sensor to its front, to one side
        const Vector3d aside(0.0, random.uniform(0.3, 2.0), random.uniform(-1.0, 1.0));
        particle.mean = Vector3d(-random.uniform(1.0, 6.0), 0.0, 0.0) + aside;
        particle.rotation = turn_between(Vector3d::UnitX(),
                                         Vector3d(5.0, random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)));
        particle.scale = {5.0, 0.1, 0.02};
      }
    }
    particles.push_back(particle);
  }
  return particles;
}

TEST(ExactExtentOfDegenerateParticles, LosesNothing) {
  const std::vector<SingleParticle> particles = degenerate();
  Shot pinhole = test::shot_of({"camera", SetKind::kCamera, false, false, 0}, 96, 64);
  expect_nothing_lost(pinhole, particles);
  expect_nothing_lost(camera_of("pandaset_front_camera", 96, 54), particles);
  Shot fisheye = pinhole;
  fisheye.camera.lens = Lens(LensKind::kOpencvFisheye, {0.02, -0.004, 0.0, 0.0, kPi});
  fisheye.camera.fx *= 0.4;  // more than 100 degrees off axis in the corners
  fisheye.camera.fy *= 0.4;
  expect_nothing_lost(fisheye, particles);
  const Shot lidar = test::shot_of({"lidar", SetKind::kLidar, false, false, 0}, 360, 32);
  expect_nothing_lost(lidar, particles);
}

}  // namespace extent_brute_test
}  // namespace simuli

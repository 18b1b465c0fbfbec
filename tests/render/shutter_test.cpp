// Tests the measurement time of a particle for a moving sensor: found if unique, and no particle is lost if
// there are several times or none. The reference are rays from the pose at their own time.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "host/core/base/angles.hpp"
#include "tests/cl/support.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace shutter_test {

using Eigen::Vector3d;
using test::Shot;

constexpr double kAlphaCut = 1.0 / 255.0;
constexpr double kOpacity = 0.5;
constexpr double kSmallest_m = 1e-4;

constexpr ShutterKind kRolling[] = {ShutterKind::kTopToBottom,
                                    ShutterKind::kBottomToTop,
                                    ShutterKind::kLeftToRight,
                                    ShutterKind::kRightToLeft};

/// Returns a camera at `start` that moves by `step_m` and rotates by `turn_rad` (axis and angle) during the
/// frame.
Shot camera_shot(ShutterKind shutter, const Vector3d& step_m, const Vector3d& turn_rad) {
  Shot shot = test::shot_of({"camera", SetKind::kCamera, true, false, 0}, 60, 44);
  shot.camera.shutter = shutter;
  const Pose start = test::forward_from_camera();
  shot.view.scene_from_sensor_start = shot.view.scene_from_sensor_end = start;
  Pose& end = shot.view.scene_from_sensor_end;
  end.translation += step_m;
  if (turn_rad.norm() > 0.0) {
    end.rotation =
        Eigen::Quaterniond(Eigen::AngleAxisd(turn_rad.norm(), turn_rad.normalized())) * start.rotation;
  }
  return shot;
}

Shot lidar_shot(SpinDirection spin, const Vector3d& step_m, double yaw_rad) {
  Shot shot = test::shot_of({"lidar", SetKind::kLidar, true, false, 0}, 240, 24);
  shot.lidar.spin = spin;
  shot.lidar.beam_divergence = 0.02;
  shot.rays = nominal_rays(shot.lidar);
  Pose& end = shot.view.scene_from_sensor_end;
  end = shot.view.scene_from_sensor_start;
  end.translation += step_m;
  end.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Vector3d::UnitZ())) * end.rotation;
  return shot;
}

/// Returns one particle on each of `count` random rays, at [nearest, farthest] metres.
std::vector<test::SingleParticle> on_rays(const Shot& shot,
                                          int count,
                                          double nearest,
                                          double farthest,
                                          double scale_m,
                                          std::vector<std::size_t>* where) {
  const auto rays = reference::rays(shot.reference());
  test::Random random(17);
  std::vector<test::SingleParticle> particles;
  for (int i = 0; i < count; ++i) {
    const auto ray = static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(rays.size())));
    test::SingleParticle one{
        .mean = rays[ray].origin + random.uniform(nearest, farthest) * rays[ray].direction,
        .opacity = kOpacity};
    one.scale.setConstant(scale_m);
    particles.push_back(one);
    if (where != nullptr) where->push_back(ray);
  }
  return particles;
}

/// Number of rays with certain decisions by brute force, and number of differing rays.
struct Comparison {
  std::size_t compared = 0;
  std::size_t covered = 0;
  std::size_t different = 0;
};

/// `lost`: minimum relative change of the transmittance that counts as a difference.
Comparison compare(const Shot& shot,
                   const std::vector<test::SingleParticle>& particles,
                   const RenderOptions& options,
                   double lost) {
  const Device& device = test::device();
  const GaussianSet set = test::set_of(shot.kind, particles);
  Renderer renderer(device, options);
  const SensorRays rays = shot.on(device, options);
  const RayResults results =
      renderer.render(ParticleBuffers(device, set, options.precision), rays, shot.view).results();

  reference::Options brute_force;
  brute_force.ignore_box = true;
  const reference::Particles exact(set);
  const reference::Sensor sensor = shot.reference();
  auto footprints = reference::project(exact, sensor, brute_force);
  for (auto& footprint : footprints) footprint.visible = footprint.opacity > kAlphaCut;
  const auto expected =
      reference::render(exact, sensor, reference::rays(sensor), footprints, brute_force, Vector3d::Zero());
  Comparison comparison;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (!(expected[i].margin >= 1e-3)) continue;
    ++comparison.compared;
    comparison.covered += expected[i].contributors > 0;
    const double error =
        std::abs(static_cast<double>(results.transmittance[i]) / expected[i].transmittance - 1.0);
    comparison.different += !(error <= lost);
  }
  return comparison;
}

// Boxes end where alpha is 1/255 of a normal distribution; for sub-pixel particles they cut off a few times
// that. A lost particle changes the transmittance by one half.
constexpr double kClipped = 0.02;
constexpr double kRounding = 2e-3;

/// Unit of speed: the image crosses the picture as fast as the shutter.
constexpr double kDistance_m = 4.0;
Vector3d crossing_m(const Camera& camera, ShutterKind shutter) {
  switch (shutter) {
    case ShutterKind::kTopToBottom:
      return {0.0, 0.0, kDistance_m * camera.height / camera.fy};
    case ShutterKind::kBottomToTop:
      return {0.0, 0.0, -kDistance_m * camera.height / camera.fy};
    case ShutterKind::kLeftToRight:
      return {0.0, kDistance_m * camera.width / camera.fx, 0.0};
    default:
      return {0.0, -kDistance_m * camera.width / camera.fx, 0.0};
  }
}

void expect_found_at(double speed, const RenderOptions& options, double lost) {
  for (const ShutterKind shutter : kRolling) {
    const Camera camera = test::small_camera(60, 44);
    const Shot shot = camera_shot(shutter, speed * crossing_m(camera, shutter), Vector3d::Zero());
    const auto particles = on_rays(shot, 12, 0.5 * kDistance_m, kDistance_m, kSmallest_m, nullptr);
    const Comparison c = compare(shot, particles, options, lost);
    SCOPED_TRACE("speed " + std::to_string(speed) + ", shutter " + std::to_string(static_cast<int>(shutter)));
    EXPECT_EQ(c.different, 0U) << "of " << c.compared << " rays";
    EXPECT_GT(c.covered, particles.size());
    EXPECT_GT(c.compared, 1000U);
  }
}

// With the rows and against them; at speed 1 an image keeps up with its row.
constexpr double kSpeeds[] = {0.3, 0.9, 1.0, 1.1, 3.0, -1.0, -3.0};

TEST(Shutter, LosesNoParticleWhateverTheSpeed) {
  for (const double speed : kSpeeds) expect_found_at(speed, paper_options(), kClipped);
}

TEST(Shutter, LosesNoParticleInDouble) {
  SIMULI_NEEDS_DOUBLE(test::device());
  RenderOptions options = paper_options();
  options.precision = Precision::kDouble;
  for (const double speed : {0.9, 1.0, 3.0}) expect_found_at(speed, options, kClipped);
}

TEST(Shutter, LosesNothingInExactExtents) {
  RenderOptions options;
  options.extent = Extent::kExact;
  for (const double speed : kSpeeds) expect_found_at(speed, options, kRounding);
}

TEST(Shutter, BoundsTakeOverWhereOneLookIsNotEnough) {
  RenderOptions options = paper_options();
  options.shutter_iterations = 1;
  for (const double speed : {0.3, 1.0}) expect_found_at(speed, options, kClipped);
}

TEST(Shutter, LosesNoParticleToATurnFasterThanItsRows) {
  // 80 degrees across 60 px: a rotation by one picture and more within the frame.
  for (const double turn : {1.5, -1.5, 2.5}) {
    for (const ShutterKind shutter : kRolling) {
      const Shot shot = camera_shot(shutter, {0.1, 0.0, 0.0}, {0.0, 0.3 * turn, turn});
      const auto particles = on_rays(shot, 12, 3.0, 20.0, kSmallest_m, nullptr);
      const Comparison c = compare(shot, particles, paper_options(), kClipped);
      EXPECT_EQ(c.different, 0U) << "turn " << turn << ", shutter " << static_cast<int>(shutter);
      EXPECT_GT(c.covered, particles.size());
    }
  }
}

TEST(Shutter, LosesNoParticleOfALidarThatPassesIt) {
  for (const Extent extent : {Extent::kUnscented, Extent::kExact}) {
    RenderOptions options;
    options.extent = extent;
    const double lost = extent == Extent::kExact ? kRounding : kClipped;
    for (const SpinDirection spin : {SpinDirection::kCounterClockwise, SpinDirection::kClockwise}) {
      // At 30 m/s; at ten times that speed, past particles at 1 to 4 m; rotation with and against the spin.
      for (const auto& [step_m, yaw_rad] : {std::pair(3.0, 0.1), {30.0, 0.0}, {3.0, 2.9}, {3.0, -2.9}}) {
        const Shot shot = lidar_shot(spin, {step_m, 0.4, 0.0}, yaw_rad);
        const auto particles = on_rays(shot, 60, 1.0, 4.0, kSmallest_m, nullptr);
        const Comparison c = compare(shot, particles, options, lost);
        EXPECT_EQ(c.different, 0U) << "step " << step_m << " m, yaw " << yaw_rad << " rad, of " << c.compared;
        EXPECT_GT(c.covered, particles.size() / 2);
      }
    }
  }
}

/// Positions along x and rows of each particle in a frame.
struct Found {
  std::vector<double> mean_x, other_x, half_x;
  std::vector<shared::Footprint> footprints;
};
Found find(const Shot& shot, const std::vector<test::SingleParticle>& particles, Precision precision) {
  const Device& device = test::device();
  RenderOptions options = paper_options();
  options.precision = precision;
  Renderer renderer(device, options);
  const SensorRays rays = shot.on(device, options);
  Pass pass = renderer.render(
      ParticleBuffers(device, test::set_of(shot.kind, particles), precision), rays, shot.view);
  const std::vector<double> records = pass.buffers().projected.records.download_double();
  Found found;
  found.footprints = pass.buffers().projected.footprints.download();
  for (std::size_t i = 0; i < particles.size(); ++i) {
    found.mean_x.push_back(records[i * SIM_RECORD + SIM_R_BOX_MEAN]);
    found.other_x.push_back(records[i * SIM_RECORD + SIM_R_BOX_OTHER]);
    found.half_x.push_back(records[i * SIM_RECORD + SIM_R_BOX_HALF]);
  }
  return found;
}

void expect_ordinary_speeds_settle(Precision precision) {
  // 30 m/s for 30 ms and 90 degrees/s: the box is at the particle's ray. A converged time is within 3/32 of a
  // row for images at three quarters of the row speed; here they have a third of it.
  constexpr double kSettled_px = 0.03, kSettled_rad = 1e-3;
  // Off-axis pixels are oblique: up to 1 / cos^2 = 2.4 in the corners.
  const double widest_px = std::sqrt(2.0 * std::log(255.0 * kOpacity) * 0.3) * 2.4;
  for (const ShutterKind shutter : kRolling) {
    const Shot shot = camera_shot(shutter, {0.9, 0.1, 0.0}, {0.0, 0.01, 0.047});
    std::vector<std::size_t> where;
    const auto particles = on_rays(shot, 32, 6.0, 60.0, kSmallest_m, &where);
    const Found found = find(shot, particles, precision);
    for (std::size_t i = 0; i < particles.size(); ++i) {
      const auto x = static_cast<double>(where[i] % 60) + 0.5;
      const auto y = static_cast<std::uint32_t>(where[i] / 60);
      EXPECT_NEAR(found.mean_x[i], x, kSettled_px) << i;
      EXPECT_LT(found.half_x[i], widest_px) << i;  // the box, not the bounds of a complete frame
      EXPECT_LE(SIM_LOW(found.footprints[i].rows), y) << i;
      EXPECT_GE(SIM_HIGH(found.footprints[i].rows), y) << i;
      EXPECT_LE(SIM_HIGH(found.footprints[i].rows) - SIM_LOW(found.footprints[i].rows), 5U) << i;
    }
  }
  for (const SpinDirection spin : {SpinDirection::kCounterClockwise, SpinDirection::kClockwise}) {
    const Shot shot = lidar_shot(spin, {3.0, 0.4, 0.0}, 0.157);
    std::vector<std::size_t> where;
    const auto particles = on_rays(shot, 32, 6.0, 60.0, kSmallest_m, &where);
    const Found found = find(shot, particles, precision);
    for (std::size_t i = 0; i < particles.size(); ++i) {
      const double x = (static_cast<double>(where[i] % 240) + 0.5) * 2.0 * kPi / 240;
      // Near the cut a particle has two positions.
      EXPECT_NEAR(std::min(std::abs(found.mean_x[i] - x), std::abs(found.other_x[i] - x)), 0.0, kSettled_rad)
          << i;
      EXPECT_LT(found.half_x[i], 0.1) << i;
    }
  }
}

TEST(Shutter, OrdinarySpeedsSettle) { expect_ordinary_speeds_settle(Precision::kFloat); }
TEST(Shutter, OrdinarySpeedsSettleInDouble) {
  SIMULI_NEEDS_DOUBLE(test::device());
  expect_ordinary_speeds_settle(Precision::kDouble);
}

}  // namespace shutter_test
}  // namespace simuli

// Tests extent = exact: no contribution is lost, the bounds are tight, and extent = unscented loses some.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <utility>
#include <vector>

#include "host/core/base/angles.hpp"
#include "tests/cl/support.hpp"
#include "tests/host/windshields.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

using Eigen::Vector3d;
using test::Shot;

constexpr double kAlphaCut = 1.0 / 255.0;

// Relative to the transmittance. A lost contribution changes it by 1/255 or more. Rays are float in both
// precisions: 6e-8 relative to footprints of at least 3e-3 rad, times about ten contributors.
constexpr double kDoubleRounding = 3e-4;
constexpr double kFloatRounding = 1.5e-3;

/// Returns near and far particles, also behind and around the sensor, up to 5 m long and up to 100 times
/// longer than thick.
GaussianSet awkward_set(SetKind kind, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<test::SingleParticle> particles;
  for (int i = 0; i < 260; ++i) {
    test::SingleParticle particle;
    particle.mean = std::exp(random.uniform(std::log(0.3), std::log(30.0))) * random.direction();
    particle.rotation = random.rotation();
    const double longest = std::exp(random.uniform(std::log(0.02), std::log(5.0)));
    for (int axis = 0; axis < 3; ++axis) {
      particle.scale[axis] = longest * std::exp(axis == 0 ? 0.0 : random.uniform(std::log(0.01), 0.0));
    }
    particle.opacity = random.uniform(0.01, 0.25);
    particles.push_back(particle);
  }
  return test::set_of(kind, particles);
}

/// Number of rays with certain decisions of the reference, and number of differing rays.
struct Comparison {
  std::size_t compared = 0;
  std::size_t covered = 0;
  std::size_t different = 0;
  double worst = 0.0;
};

Comparison compare(const Shot& shot, const RenderOptions& options, double rounding) {
  const Device& device = test::device();
  const GaussianSet set = awkward_set(shot.kind, 5);
  Renderer renderer(device, options);
  const SensorRays rays = shot.on(device, options);
  const RayResults results =
      renderer.render(ParticleBuffers(device, set, options.precision), rays, shot.view).results();

  reference::Options without_box;
  without_box.ignore_box = true;
  const reference::Particles particles(set);
  const reference::Sensor sensor = shot.reference();
  auto footprints = reference::project(particles, sensor, without_box);
  for (auto& footprint : footprints) footprint.visible = footprint.opacity > kAlphaCut;
  const auto expected = reference::render(
      particles, sensor, reference::rays(sensor), footprints, without_box, Vector3d::Zero());
  EXPECT_EQ(results.rays, expected.size());

  Comparison comparison;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (!(expected[i].margin >= rounding)) continue;
    const double error =
        std::abs(static_cast<double>(results.transmittance[i]) / expected[i].transmittance - 1.0);
    ++comparison.compared;
    comparison.covered += expected[i].contributors > 0;
    comparison.different += !(error <= rounding);
    comparison.worst = std::max(comparison.worst, error);
  }
  return comparison;
}

void expect_nothing_lost(const char* name, const Shot& shot, Precision precision) {
  SCOPED_TRACE(name);
  RenderOptions options;
  options.extent = Extent::kExact;
  options.precision = precision;
  const double rounding = precision == Precision::kDouble ? kDoubleRounding : kFloatRounding;
  const Comparison c = compare(shot, options, rounding);
  EXPECT_EQ(c.different, 0U) << "of " << c.compared << " rays, worst " << c.worst;
  EXPECT_GT(c.compared, shot.kind == SetKind::kCamera ? 300U : 500U);
  EXPECT_GT(2 * c.covered, c.compared);
}

Shot camera_shot(bool moving) {
  return test::shot_of({"camera", SetKind::kCamera, moving, false, 0}, 60, 44);
}

/// `scale`: factor of focal lengths of small_camera(). 0.9: 60 degrees off axis in the corners; 0.4: more
/// than 100 degrees.
Shot fisheye_shot(double scale, bool moving) {
  Shot shot = camera_shot(moving);
  shot.camera.lens = Lens(LensKind::kOpencvFisheye, {0.02, -0.004, 0.0, 0.0, kPi});
  shot.camera.fx *= scale;
  shot.camera.fy *= scale;
  return shot;
}

Shot windshield_shot(const Windshield& glass, Shot shot) {
  shot.camera.lens = shot.camera.lens.behind(glass);
  return shot;
}

Shot panorama_shot() {
  Shot shot = camera_shot(false);
  shot.camera = test::small_camera(96, 48);
  shot.camera.lens = Lens(LensKind::kEquirectangular, {});
  shot.camera.fx = shot.camera.fy = 96.0 / (2.0 * kPi);
  return shot;
}

/// Beams with lever arms and a divergence, measured rays (azimuth offsets and time jitter).
Shot lidar_shot(bool moving, bool measured, SpinDirection spin) {
  Shot shot = test::shot_of({"lidar", SetKind::kLidar, moving, measured, 0}, 120, 16);
  shot.lidar.beam_divergence = 0.012;
  shot.lidar.spin = spin;
  shot.rays = nominal_rays(shot.lidar);
  if (measured) {
    test::Random random(3);
    for (std::size_t i = 0; i < shot.rays.elevation.size(); ++i) {
      shot.rays.elevation[i] += static_cast<float>(random.uniform(-0.01, 0.01));
      shot.rays.azimuth[i] += static_cast<float>(random.uniform(-0.01, 0.01));
      shot.rays.time_fraction[i] += static_cast<float>(random.uniform(-0.02, 0.02));
    }
  }
  return shot;
}

TEST(ExactExtent, LosesNothingInDouble) {
  SIMULI_NEEDS_DOUBLE(test::device());
  expect_nothing_lost("pinhole", camera_shot(false), Precision::kDouble);
  expect_nothing_lost("pinhole, rolling shutter", camera_shot(true), Precision::kDouble);
  expect_nothing_lost("fisheye, rolling shutter", fisheye_shot(0.9, true), Precision::kDouble);
  expect_nothing_lost("wide fisheye, rolling shutter", fisheye_shot(0.4, true), Precision::kDouble);
  expect_nothing_lost("pinhole behind glass",
                      windshield_shot(test::glass_before_the_lens(), camera_shot(false)),
                      Precision::kDouble);
  expect_nothing_lost("fisheye behind glass, rolling shutter",
                      windshield_shot(test::glass_by_its_way_back(), fisheye_shot(0.9, true)),
                      Precision::kDouble);
  expect_nothing_lost("panorama", panorama_shot(), Precision::kDouble);
  expect_nothing_lost("lidar", lidar_shot(false, false, SpinDirection::kClockwise), Precision::kDouble);
  expect_nothing_lost(
      "driving lidar", lidar_shot(true, true, SpinDirection::kCounterClockwise), Precision::kDouble);
  expect_nothing_lost(
      "driving clockwise lidar", lidar_shot(true, true, SpinDirection::kClockwise), Precision::kDouble);
}

TEST(ExactExtent, LosesNothingInFloat) {
  expect_nothing_lost("pinhole", camera_shot(false), Precision::kFloat);
  expect_nothing_lost(
      "driving lidar", lidar_shot(true, true, SpinDirection::kCounterClockwise), Precision::kFloat);
}

TEST(ExactExtent, UnscentedLosesSomething) {
  const Comparison c = compare(camera_shot(false), paper_options(), kFloatRounding);
  EXPECT_GT(c.different, 0U) << "of " << c.compared << " rays";
  EXPECT_GT(c.worst, kAlphaCut);
}

/// Minimum and maximum of an ellipsoid's projection.
struct Span {
  double low = 1e30, high = -1e30;
  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] double width() const { return high - low; }
};

/// Returns points on the surface of particle i's cutoff ellipsoid: affine images of a fine spiral on the
/// sphere.
std::vector<Vector3d> surface(const GaussianSet& set, Eigen::Index i) {
  constexpr int kPoints = 20000;  // the outermost point is within 1e-3 of the half-width
  const double opacity = 1.0 / (1.0 + std::exp(-static_cast<double>(set.opacity_logit()(i))));
  const double reach = std::sqrt(2.0 * std::log(opacity / kAlphaCut));
  const Eigen::Vector4d q = set.rotation().row(i).transpose().cast<double>();
  const Eigen::Matrix3d rotation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
  const Vector3d scale = set.log_scale().row(i).transpose().cast<double>().array().exp();
  std::vector<Vector3d> points;
  for (int k = 0; k < kPoints; ++k) {
    const double z = 1.0 - (2.0 * k + 1.0) / kPoints;
    const double turn = kPi * (3.0 - std::sqrt(5.0)) * k;
    const double flat = std::sqrt(1.0 - z * z);
    const Vector3d unit(flat * std::cos(turn), flat * std::sin(turn), z);
    points.push_back(set.mean().row(i).transpose().cast<double>() +
                     reach * (rotation * scale.cwiseProduct(unit)));
  }
  return points;
}

/// Boxes of the particles in device buffers.
struct Boxes {
  std::vector<double> records;
  std::vector<shared::Footprint> footprints;
  Boxes(const Shot& shot, const GaussianSet& set) {
    const Device& device = test::device();
    RenderOptions options;
    options.extent = Extent::kExact;
    options.camera_filter_px2 = 0.0;
    options.culling = Culling::kOff;  // particles between two columns also have a box
    Renderer renderer(device, options);
    const SensorRays rays = shot.on(device, options);
    Pass pass = renderer.render(ParticleBuffers(device, set, options.precision), rays, shot.view);
    records = pass.buffers().projected.records.download_double();
    footprints = pass.buffers().projected.footprints.download();
  }
  [[nodiscard]] double at(Eigen::Index i, std::size_t entry) const {
    return records[static_cast<std::size_t>(i) * SIM_RECORD + entry];
  }
};

/// Returns particles ahead of the sensor at 2 to 12 m; most have a compact projection.
GaussianSet set_ahead(SetKind kind) {
  test::Random random(9);
  std::vector<test::SingleParticle> particles;
  for (int i = 0; i < 160; ++i) {
    test::SingleParticle particle;
    particle.mean = {random.uniform(2.0, 12.0), random.uniform(-4.0, 4.0), random.uniform(-3.0, 3.0)};
    particle.rotation = random.rotation();
    for (int axis = 0; axis < 3; ++axis) particle.scale[axis] = 0.4 * std::exp(random.uniform(-4.6, 0.0));
    particle.opacity = random.uniform(0.1, 0.9);
    particles.push_back(particle);
  }
  return test::set_of(kind, particles);
}

// A box exceeds the sampled silhouette by its padding (a thousandth of the width on either side) and the
// sampling error. Boxes 2 % too small or too large fail.
constexpr double kTight = 0.005;

TEST(ExactExtent, BoundsPinholeSilhouettesTightly) {
  constexpr double kPadding_px = 0.05;
  Shot shot = test::shot_of({"camera", SetKind::kCamera, false, false, 0}, 400, 400);
  const GaussianSet set = set_ahead(SetKind::kCamera);
  const Boxes boxes(shot, set);
  int seen = 0;
  for (Eigen::Index i = 0; i < set.size(); ++i) {
    Span x, y;
    bool in_picture = true;
    for (const Vector3d& p : surface(set, i)) {  // the camera points along x, z is up
      if (p.x() < 0.1) in_picture = false;
      x.add(shot.camera.cx - shot.camera.fx * p.y() / p.x());
      y.add(shot.camera.cy - shot.camera.fy * p.z() / p.x());
    }
    if (!in_picture || x.low < 0 || x.high > 400 || y.low < 0 || y.high > 400) continue;
    const auto& footprint = boxes.footprints[static_cast<std::size_t>(i)];
    if (SIM_TILES(footprint) == 0) {  // between the pixel centres
      EXPECT_LT(std::min(x.width(), y.width()), 1.0) << "particle " << i;
      continue;
    }
    ++seen;
    const double low = boxes.at(i, SIM_R_BOX_MEAN) - boxes.at(i, SIM_R_BOX_HALF);
    const double high = boxes.at(i, SIM_R_BOX_MEAN) + boxes.at(i, SIM_R_BOX_HALF);
    EXPECT_LE(low, x.low) << "particle " << i;
    EXPECT_GE(high, x.high) << "particle " << i;
    EXPECT_GE(low, x.low - kTight * x.width() - kPadding_px) << "particle " << i;
    EXPECT_LE(high, x.high + kTight * x.width() + kPadding_px) << "particle " << i;
    const double slack = kTight * y.width() + kPadding_px;
    const int first = static_cast<int>(SIM_LOW(footprint.rows));
    const int last = static_cast<int>(SIM_HIGH(footprint.rows));
    EXPECT_LE(first, std::ceil(y.low - 0.5)) << "particle " << i;
    EXPECT_GE(last, std::floor(y.high - 0.5)) << "particle " << i;
    EXPECT_GE(first, std::ceil(y.low - slack - 0.5)) << "particle " << i;
    EXPECT_LE(last, std::floor(y.high + slack - 0.5)) << "particle " << i;
  }
  EXPECT_GT(seen, 60);
}

TEST(ExactExtent, BoundsLidarSilhouettesTightly) {
  constexpr double kPadding_rad = 1e-5;
  // Elevations are bounded over the complete width: some percent too large.
  constexpr double kTightElevation = 0.1;
  Shot shot = test::shot_of({"lidar", SetKind::kLidar, false, false, 0}, 64, 1024);
  const GaussianSet set = set_ahead(SetKind::kLidar);
  const Boxes boxes(shot, set);
  const double cut = shot.lidar.azimuth_first - 0.5 * shot.lidar.azimuth_span / shot.lidar.columns;
  const auto& rows = shot.lidar.rows;
  int seen = 0;
  for (Eigen::Index i = 0; i < set.size(); ++i) {
    const auto& footprint = boxes.footprints[static_cast<std::size_t>(i)];
    Span x, y;
    bool aside = true;
    for (const Vector3d& p : surface(set, i)) {
      if (p.x() < 0.1) aside = false;
      x.add(std::atan2(p.y(), p.x()) - cut + 2.0 * kPi);
      y.add(std::atan2(p.z(), std::hypot(p.x(), p.y())));
    }
    if (!aside || y.low < rows.back().elevation || y.high > rows.front().elevation) continue;
    if (SIM_TILES(footprint) == 0) {
      EXPECT_LT(y.width(), rows[0].elevation - rows[1].elevation) << "particle " << i;
      continue;
    }
    ++seen;
    const double mean = x.low + std::remainder(boxes.at(i, SIM_R_BOX_MEAN) - x.low, 2.0 * kPi);
    const double half = boxes.at(i, SIM_R_BOX_HALF);
    EXPECT_LE(mean - half, x.low) << "particle " << i;
    EXPECT_GE(mean + half, x.high) << "particle " << i;
    EXPECT_LE(2.0 * half, x.width() * (1.0 + 2.0 * kTight) + kPadding_rad) << "particle " << i;
    const double slack = kTightElevation * y.width() + kPadding_rad;
    const auto outside = [&](int row, double low, double high) {
      const double elevation = rows[static_cast<std::size_t>(row)].elevation;
      return elevation < low || elevation > high;
    };
    const int first = static_cast<int>(SIM_LOW(footprint.rows));
    const int last = static_cast<int>(SIM_HIGH(footprint.rows));
    EXPECT_TRUE(first == 0 || outside(first - 1, y.low, y.high)) << "particle " << i;
    EXPECT_TRUE(last == 1023 || outside(last + 1, y.low, y.high)) << "particle " << i;
    EXPECT_FALSE(outside(first, y.low - slack, y.high + slack)) << "particle " << i;
    EXPECT_FALSE(outside(last, y.low - slack, y.high + slack)) << "particle " << i;
  }
  EXPECT_GT(seen, 40);
}

}  // namespace
}  // namespace simuli

// Tests the three projections: they agree for affine maps, and for curved maps Monte Carlo agrees with the
// sigma points. Compared are the boxes along x in the device's records.
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "tests/cl/support.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

using Eigen::Vector3d;
using test::SingleParticle;

constexpr double kOpacity = 0.5;
// Monte Carlo standard deviations come from 100 independent pairs of samples, equal for all particles: a mean
// error of 1 / sqrt(200), twice that in the worst direction.
constexpr double kSampling = 0.15;

struct Box {
  double mean = 0.0;  // px or rad
  double half = 0.0;
};

class ProjectionOption : public testing::TestWithParam<test::SceneCase> {
 protected:
  [[nodiscard]] bool camera() const { return GetParam().kind == SetKind::kCamera; }

  /// Returns the boxes of all particles, which must be visible.
  [[nodiscard]] std::vector<Box> boxes(Projection projection, const std::vector<SingleParticle>& particles) {
    RenderOptions options = paper_options();
    options.projection = projection;
    options.camera_filter_px2 = 0.0;  // boxes without the filter
    const test::Shot shot = camera() ? test::shot_of(GetParam(), 72, 50) : test::shot_of(GetParam(), 150, 20);
    // A ray grid has the tiles of one sensor: the picture is large enough for all particles below.
    GaussianSet set(GetParam().kind, GetParam().sh_degree, static_cast<Eigen::Index>(particles.size()));
    set.params.leftCols(param_rows(0)) = test::set_of(GetParam().kind, particles).params;
    Renderer renderer(device_, options);
    const SensorRays rays = shot.on(device_, options);
    Pass pass = renderer.render(ParticleBuffers(device_, set, Precision::kFloat), rays, shot.view);
    const std::vector<double> records = pass.buffers().projected.records.download_double();
    const std::vector<std::uint32_t> keys = pass.buffers().projected.keys.download();
    std::vector<Box> out;
    for (std::size_t i = 0; i < particles.size(); ++i) {
      EXPECT_NE(keys[i], 0xffffffffU) << "particle " << i << " is not seen";
      out.push_back({records[i * SIM_RECORD + SIM_R_BOX_MEAN], records[i * SIM_RECORD + SIM_R_BOX_HALF]});
    }
    return out;
  }
  /// Returns a position ahead, slightly off the axis.
  [[nodiscard]] static Vector3d place(test::Random& random, double range_m) {
    return range_m * Vector3d(1.0, random.uniform(-0.4, 0.4), random.uniform(-0.25, 0.1)).normalized();
  }

  Device device_ = test::device();
};

TEST_P(ProjectionOption, SmallParticlesHaveTheSameBox) {
  // A hundredth of the range, wide enough to reach a beam: curvature changes about 1e-4 of the box.
  // Linearised offsets are 1/32 of a standard deviation, 0.01 px with coordinates of up to 72 px, rounded to
  // 4e-6 px.
  constexpr double kShare = 0.015, kBend = 5e-3;
  test::Random random(5);
  std::vector<SingleParticle> particles;
  for (int i = 0; i < 32; ++i) {
    const double range_m = random.uniform(3.0, 40.0);
    SingleParticle one{.mean = place(random, range_m), .opacity = kOpacity};
    one.rotation = random.rotation();
    for (int k = 0; k < 3; ++k) one.scale[k] = kShare * range_m * random.uniform(0.7, 1.0);
    particles.push_back(one);
  }
  const auto unscented = boxes(Projection::kUnscented, particles);
  const auto linearized = boxes(Projection::kLinearized, particles);
  const auto sampled = boxes(Projection::kMonteCarlo, particles);
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const Box& box = unscented[i];
    ASSERT_GT(box.half, 0.0);
    EXPECT_NEAR(linearized[i].mean, box.mean, kBend * box.half) << i;
    EXPECT_NEAR(linearized[i].half, box.half, kBend * box.half) << i;
    EXPECT_NEAR(sampled[i].mean, box.mean, kBend * box.half) << i;  // samples are pairs of opposite offsets
    EXPECT_NEAR(sampled[i].half, box.half, kSampling * box.half) << i;
  }
}

TEST_P(ProjectionOption, MonteCarloSidesWithTheSigmaPoints) {
  // Long particles at an angle to the line of sight, a few standard deviations away: the mean of the image
  // differs from the image of the mean.
  test::Random random(6);
  std::vector<SingleParticle> particles;
  for (int i = 0; i < 32; ++i) {
    SingleParticle one{.mean = place(random, 5.0), .scale = {0.9, 0.1, 0.1}, .opacity = kOpacity};
    const double side = i % 2 == 0 ? 1.0 : -1.0;
    one.rotation = Eigen::AngleAxisd(side * random.uniform(0.5, 1.0), Vector3d::UnitZ());
    particles.push_back(one);
  }
  const auto unscented = boxes(Projection::kUnscented, particles);
  const auto linearized = boxes(Projection::kLinearized, particles);
  const auto sampled = boxes(Projection::kMonteCarlo, particles);
  double from_unscented = 0.0, from_linearized = 0.0;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    from_unscented += std::abs(unscented[i].mean - sampled[i].mean) / sampled[i].half;
    from_linearized += std::abs(linearized[i].mean - sampled[i].mean) / sampled[i].half;
  }
  const auto count = static_cast<double>(particles.size());
  RecordProperty("from_unscented", std::to_string(from_unscented / count));
  RecordProperty("from_linearized", std::to_string(from_linearized / count));
  // A significant difference, at least twice as large.
  EXPECT_GT(from_linearized / count, 0.01);
  EXPECT_LT(from_unscented, 0.5 * from_linearized);
}

TEST_P(ProjectionOption, AStraightMapIsExact) {
  // A pinhole's map is affine at one depth, for any size: x = cx + f X / Z. A LiDAR's map is affine in the
  // limit of small particles: a ball s at the horizontal distance d has the width s / d.
  constexpr double kRounding = 2e-3;  // of linearised offsets; see above
  const double reach = std::sqrt(2.0 * std::log(255.0 * kOpacity));
  const double kFocal_px = 0.6 * 72.0;
  test::Random random(7);
  std::vector<SingleParticle> particles;
  std::vector<double> expected;
  for (int i = 0; i < 16; ++i) {
    SingleParticle one{.mean = place(random, 10.0), .opacity = kOpacity};
    if (camera()) {
      one.scale = {1e-4, random.uniform(0.3, 2.0), random.uniform(0.3, 2.0)};
      expected.push_back(reach * kFocal_px * one.scale[1] / one.mean.x());
    } else {
      one.scale.setConstant(random.uniform(0.11, 0.15));  // none fits between two beams
      expected.push_back(reach * one.scale[0] / one.mean.head<2>().norm());
    }
    particles.push_back(one);
  }
  const auto sampled = boxes(Projection::kMonteCarlo, particles);
  const auto unscented = boxes(Projection::kUnscented, particles);
  const auto linearized = boxes(Projection::kLinearized, particles);
  for (std::size_t i = 0; i < particles.size(); ++i) {
    EXPECT_NEAR(unscented[i].half, expected[i], kRounding * expected[i]) << i;
    EXPECT_NEAR(linearized[i].half, expected[i], kRounding * expected[i]) << i;
    EXPECT_NEAR(sampled[i].half, expected[i], kSampling * expected[i]) << i;
    EXPECT_NEAR(linearized[i].mean, unscented[i].mean, kRounding * expected[i]) << i;
    EXPECT_NEAR(sampled[i].mean, unscented[i].mean, kRounding * expected[i]) << i;
    // All particles have the same samples, and so the same error if the map is exactly affine.
    if (camera()) {
      EXPECT_NEAR(sampled[i].half / expected[i], sampled[0].half / expected[0], kRounding) << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All,
                         ProjectionOption,
                         testing::Values(test::kCameraStill, test::kLidarStill),
                         [](const auto& pair) { return std::string(pair.param.name); });

}  // namespace
}  // namespace simuli

// The OpenCL forward pass against the sequential double-precision reference (tests/support).
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <tuple>
#include <vector>

#include "tests/cl/support.hpp"

namespace simuli {
namespace {

using test::SceneCase;

struct ForwardCase {
  SceneCase scene;
  Precision precision;
  LaneShape shape;
};
void PrintTo(const ForwardCase& c, std::ostream* out) { PrintTo(c.scene, out); }

// Results are compared as floats. A float pipeline adds the rounding of directions (6e-8) against scales
// of a few centimetres some metres away, squared distances up to 11 and hundreds of terms.
struct Tolerance {
  double transmittance;
  double feature;     // features reach 4 times the range of the transmittance
  double distance_m;  // sums of weights times up to 20 m
  double decided;     // rays with a yes-or-no decision closer than this may go the other way
  double compared;    // share of rays that are decided
};
constexpr Tolerance kDoubleTolerance{2e-6, 8e-6, 4e-5, 1e-6, 0.99};
constexpr Tolerance kFloatTolerance{3e-3, 1.2e-2, 6e-2, 1e-3, 0.3};

class Forward : public testing::TestWithParam<ForwardCase> {};

TEST_P(Forward, MatchesTheReference) {
  const auto& [scene, precision, shape] = GetParam();
  const Device device = Device::best();
  if (precision == Precision::kDouble) SIMULI_NEEDS_DOUBLE(device);
  const test::SetRecipe recipe{
      .count = 400, .low = {-12, -12, -4}, .high = {12, 12, 4}, .scale_min = 0.05, .scale_max = 0.8};
  const GaussianSet set = test::set_for(scene, recipe, 7);
  const bool camera = scene.kind == SetKind::kCamera;
  const test::Shot shot = camera ? test::shot_of(scene, 72, 50) : test::shot_of(scene, 150, 20);

  RenderOptions options;
  options.precision = precision;
  options.shape = shape;
  Renderer renderer(device, options);
  const SensorRays rays = shot.on(device, options);
  const ParticleBuffers particles(device, set, precision);
  renderer.render(particles, rays, shot.view);
  const RayResults results = renderer.results();
  const auto& background = shot.view.background;
  const auto expected = reference::render(reference::Particles(set),
                                          shot.reference(),
                                          {},
                                          {static_cast<double>(background[0]),
                                           static_cast<double>(background[1]),
                                           static_cast<double>(background[2])});
  ASSERT_EQ(results.rays, expected.size());

  const Tolerance& tolerance = precision == Precision::kDouble ? kDoubleTolerance : kFloatTolerance;
  std::size_t compared = 0, covered = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (!(expected[i].margin >= tolerance.decided)) continue;
    ++compared;
    covered += expected[i].contributors > 0;
    for (int k = 0; k < 3; ++k) {
      ASSERT_NEAR(static_cast<double>(results.feature[k][i]), expected[i].feature[k], tolerance.feature)
          << "ray " << i << " channel " << k;
    }
    ASSERT_NEAR(
        static_cast<double>(results.transmittance[i]), expected[i].transmittance, tolerance.transmittance)
        << "ray " << i;
    ASSERT_NEAR(static_cast<double>(results.distance[i]), expected[i].distance, tolerance.distance_m)
        << "ray " << i;
    if (!camera && expected[i].median_margin > tolerance.decided) {
      ASSERT_NEAR(static_cast<double>(results.median[i]), expected[i].median_distance, tolerance.distance_m)
          << "ray " << i;
    }
  }
  EXPECT_GT(static_cast<double>(compared), tolerance.compared * static_cast<double>(expected.size()));
  EXPECT_GT(covered, compared / 3);
}

// Every variant is seconds of compile time: shapes and precisions meet on the cases that differ most.
INSTANTIATE_TEST_SUITE_P(
    All,
    Forward,
    testing::Values(ForwardCase{test::kCameraStill, Precision::kFloat, test::kCpuShape},
                    ForwardCase{test::kCameraSh3, Precision::kFloat, test::kCpuShape},
                    ForwardCase{test::kCameraRolling, Precision::kFloat, test::kCpuShape},
                    ForwardCase{test::kLidarStill, Precision::kFloat, test::kCpuShape},
                    ForwardCase{test::kLidarLevers, Precision::kFloat, test::kCpuShape},
                    ForwardCase{test::kLidarMoving, Precision::kFloat, test::kCpuShape},
                    ForwardCase{test::kCameraSh3, Precision::kDouble, test::kDefaultShape},
                    ForwardCase{test::kCameraRolling, Precision::kDouble, test::kDefaultShape},
                    ForwardCase{test::kLidarMoving, Precision::kDouble, test::kDefaultShape},
                    ForwardCase{test::kCameraStill, Precision::kFloat, test::kGpuShape},
                    ForwardCase{test::kLidarMoving, Precision::kFloat, test::kGpuShape},
                    ForwardCase{test::kCameraStill, Precision::kFloat, LaneShape{1, 1, 256}},
                    ForwardCase{test::kLidarMoving, Precision::kFloat, LaneShape{4, 4, 16}}),
    [](const auto& instance) {
      const ForwardCase& c = instance.param;
      return std::string(c.scene.name) + (c.precision == Precision::kFloat ? "_float" : "_double") +
             "_lanes" + std::to_string(c.shape.lanes) + "x" + std::to_string(c.shape.work_items);
    });

}  // namespace
}  // namespace simuli

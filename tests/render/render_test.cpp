// Tests the OpenCL forward pass against the sequential double-precision reference (tests/support).
#include <gtest/gtest.h>
#include <string>

#include "tests/cl/support.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

using test::SceneCase;

struct ForwardCase {
  SceneCase scene;
  Precision precision;
  LaneShape shape;
};
void PrintTo(const ForwardCase& c, std::ostream* out) { PrintTo(c.scene, out); }

class Forward : public testing::TestWithParam<ForwardCase> {};

TEST_P(Forward, MatchesTheReference) {
  const auto& [scene, precision, shape] = GetParam();
  const Device& device = test::device();
  if (precision == Precision::kDouble) SIMULI_NEEDS_DOUBLE(device);
  const test::SetRecipe recipe{
      .count = 400, .low = {-12, -12, -4}, .high = {12, 12, 4}, .scale_min = 0.05, .scale_max = 0.8};
  const GaussianSet set = test::set_for(scene, recipe, 7);
  const bool camera = scene.kind == SetKind::kCamera;
  test::Shot shot = camera ? test::shot_of(scene, 72, 50) : test::shot_of(scene, 150, 20);
  shot.view.drop = test::some_ray_drop(3);

  RenderOptions options = paper_options();
  options.precision = precision;
  options.shape = shape;
  Renderer renderer(device, options);
  const SensorRays rays = shot.on(device, options);
  const ParticleBuffers particles(device, set, precision);
  const RayResults results = renderer.render(particles, rays, shot.view).results();
  const auto& background = shot.view.background;
  const auto expected = reference::render(reference::Particles(set),
                                          shot.reference(),
                                          {},
                                          {static_cast<double>(background[0]),
                                           static_cast<double>(background[1]),
                                           static_cast<double>(background[2])});
  const bool is_double = precision == Precision::kDouble;
  const test::RayCounts counts = test::expect_same_rays(
      results, expected, scene.kind, is_double ? test::kDoubleTolerance : test::kFloatTolerance);
  EXPECT_GT(counts.compared, is_double ? 0.99 : 0.3);
  EXPECT_GT(counts.covered, 1.0 / 3.0);
  test::expect_drop_logits(results, shot.view, scene.kind);
}

// Each variant takes seconds to compile: shapes and precisions are tested with the most different cases.
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
                    ForwardCase{test::kCameraStill, Precision::kFloat, LaneShape{1, 4, 64}},
                    ForwardCase{test::kLidarMoving, Precision::kFloat, LaneShape{4, 4, 16}}),
    [](const auto& pair) {
      const ForwardCase& c = pair.param;
      return std::string(c.scene.name) + (c.precision == Precision::kFloat ? "_float" : "_double") +
             "_lanes" + std::to_string(c.shape.lanes) + "x" + std::to_string(c.shape.work_items);
    });

}  // namespace
}  // namespace simuli

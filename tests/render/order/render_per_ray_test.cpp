// Tests options of pictures beyond the default: per-ray order, colours along each ray, fewer bands, built-in
// functions (host/device/render/options/options.hpp).
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "host/device/render/options/quality.hpp"
#include "tests/cl/support.hpp"
#include "tests/host/expect_error.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace render_per_ray_test {

using test::SceneCase;

test::Shot shot_for(const SceneCase& scene) {
  return scene.kind == SetKind::kCamera ? test::shot_of(scene, 72, 50) : test::shot_of(scene, 150, 20);
}

/// Wide overlapping particles: the order by range often differs from the order along a ray.
GaussianSet crowd(const SceneCase& scene, Eigen::Index count = 600) {
  const test::SetRecipe recipe{.count = count,
                               .low = {-12, -12, -4},
                               .high = {12, 12, 4},
                               .scale_min = 0.05,
                               .scale_max = 1.8,
                               .opacity_max = 0.6};
  return test::set_for(scene, recipe, 7);
}

RayResults render(const Device& device,
                  const GaussianSet& set,
                  const test::Shot& shot,
                  const RenderOptions& options) {
  Renderer renderer(device, options);
  const SensorRays rays = shot.on(device, options);
  return renderer.render(ParticleBuffers(device, set, options), rays, shot.view).results();
}

struct OrderCase {
  SceneCase scene;
  Precision precision;
  LaneShape shape;
  ShDirection direction;
};
void PrintTo(const OrderCase& c, std::ostream* out) { PrintTo(c.scene, out); }

class PerRay : public testing::TestWithParam<OrderCase> {};

TEST_P(PerRay, MatchesTheReference) {
  const auto& [scene, precision, shape, direction] = GetParam();
  const Device& device = test::device();
  if (precision == Precision::kDouble) SIMULI_NEEDS_DOUBLE(device);
  SIMULI_NEEDS_WINDOWS(device, shape);
  const GaussianSet set = crowd(scene);
  test::Shot shot = shot_for(scene);
  shot.view.drop = test::some_ray_drop(3);
  RenderOptions options = paper_options();
  options.precision = precision;
  options.shape = shape;
  options.order = Order::kPerRay;
  options.sh_direction = direction;
  const RayResults results = render(device, set, shot, options);
  const auto& background = shot.view.background;
  const auto reference_of = [&](bool per_ray) {
    reference::Options twin;
    twin.per_ray_order = per_ray;
    twin.per_ray_features = direction == ShDirection::kRay;
    return reference::render(reference::Particles(set),
                             shot.reference(),
                             twin,
                             {static_cast<double>(background[0]),
                              static_cast<double>(background[1]),
                              static_cast<double>(background[2])});
  };
  const auto expected = reference_of(true), by_range = reference_of(false);
  const bool is_double = precision == Precision::kDouble;
  const test::Tolerance& tolerance = is_double ? test::kDoubleTolerance : test::kFloatTolerance;
  EXPECT_GT(test::expect_same_rays(results, expected, scene.kind, tolerance).compared,
            is_double ? 0.98 : 0.2);
  test::expect_drop_logits(results, shot.view, scene.kind);
  double otherwise = 0.0;  // error of the order by range
  int most = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    most = std::max(most, expected[i].contributors);
    otherwise = std::max(otherwise, (expected[i].feature - by_range[i].feature).cwiseAbs().maxCoeff());
  }
  EXPECT_GT(otherwise, 2.0 * tolerance.feature);
  EXPECT_GT(most, 20) << "no ray needs a second round";
}

INSTANTIATE_TEST_SUITE_P(
    All,
    PerRay,
    testing::Values(OrderCase{test::kCameraSh3, Precision::kDouble, test::kDefaultShape, ShDirection::kRay},
                    OrderCase{test::kCameraStill, Precision::kFloat, test::kCpuShape, ShDirection::kParticle},
                    OrderCase{test::kCameraStill, Precision::kFloat, test::kGpuShape, ShDirection::kParticle},
                    OrderCase{test::kLidarMoving, Precision::kDouble, test::kDefaultShape, ShDirection::kRay},
                    OrderCase{
                        test::kLidarMoving, Precision::kFloat, test::kCpuShape, ShDirection::kParticle}),
    [](const auto& pair) {
      const OrderCase& c = pair.param;
      return std::string(c.scene.name) + (c.precision == Precision::kFloat ? "_float" : "_double") +
             "_lanes" + std::to_string(c.shape.lanes);
    });

TEST(RaySh, InOrderOfRangeMatchesTheReference) {
  const Device& device = test::device();
  SIMULI_NEEDS_DOUBLE(device);
  const GaussianSet set = crowd(test::kCameraSh3);
  const test::Shot shot = shot_for(test::kCameraSh3);
  RenderOptions options = paper_options();
  options.precision = Precision::kDouble;
  options.sh_direction = ShDirection::kRay;
  const RayResults results = render(device, set, shot, options);
  reference::Options twin;
  twin.per_ray_features = true;
  const auto& background = shot.view.background;
  const auto expected = reference::render(reference::Particles(set),
                                          shot.reference(),
                                          twin,
                                          {static_cast<double>(background[0]),
                                           static_cast<double>(background[1]),
                                           static_cast<double>(background[2])});
  test::expect_same_rays(results, expected, SetKind::kCamera, test::kDoubleTolerance);
}

TEST(RaySh, SumsThatAreNoNumbersAreNotSpread) {
  const Device& device = test::device();
  GaussianSet set = crowd(test::kCameraSh3, 60);
  set.sh(2).row(3).setConstant(3e38F);  // 0 towards a particle straight ahead, large slightly beside it
  set.mean().row(3) << 5.0F, 0.0F, 0.0F;
  RenderOptions options = paper_options();
  options.sh_direction = ShDirection::kRay;
  for (const Order order : {Order::kRange, Order::kWindow, Order::kPerRay}) {
    options.order = order;
    const RayResults results = render(device, set, shot_for(test::kCameraSh3), options);
    for (const auto& feature : results.feature) {
      for (const float v : feature) ASSERT_TRUE(std::isfinite(v));
    }
  }
}

TEST(ShDegrees, LeftOutBandsAreNotThere) {
  const Device& device = test::device();
  const GaussianSet set = crowd(test::kCameraSh3);
  GaussianSet cut(set.kind, 1, set.size());
  cut.params = set.params.leftCols(param_rows(1));
  const test::Shot shot = shot_for(test::kCameraSh3);
  RenderOptions options = paper_options();
  const RayResults expected = render(device, cut, shot, options);
  options.sh_degree = 1;
  const ParticleBuffers buffers(device, set, options);
  EXPECT_EQ(buffers.sh_degree, 1);
  EXPECT_EQ(buffers.params.count(), static_cast<std::size_t>(param_rows(1)) * buffers.stride);
  const RayResults found = render(device, set, shot, options);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(found.feature[k], expected.feature[k]);
}

TEST(ShStorage, HalvesAreRoundedCoefficients) {
  const Device& device = test::device();
  for (const SceneCase& scene : {test::kCameraSh3, test::kLidarMoving}) {
    GaussianSet set = crowd(scene);
    set.sh(0).row(0).setConstant(1e-7F);  // a denormal half
    const test::Shot shot = shot_for(scene);
    RenderOptions options = paper_options();
    options.sh_storage = ShStorage::kHalf;
    const ParticleBuffers buffers(device, set, options);
    const GaussianSet rounded = buffers.download();
    for (Eigen::Index row = 0; row < set.params.cols(); ++row) {
      for (Eigen::Index i = 0; i < set.size(); ++i) {
        const float value = set.params(i, row);
        const float expected = row < kShRow ? value : static_cast<float>(Eigen::half(value));
        ASSERT_EQ(rounded.params(i, row), expected) << row;
      }
    }
    EXPECT_NE(rounded.params, set.params);
    // Equal bits as from rounded parameters, also for colours along each ray.
    for (const ShDirection direction : {ShDirection::kParticle, ShDirection::kRay}) {
      options.sh_storage = ShStorage::kHalf;
      options.sh_direction = direction;
      const RayResults halves = render(device, set, shot, options);
      options.sh_storage = ShStorage::kFull;
      const RayResults full = render(device, rounded, shot, options);
      for (int k = 0; k < 3; ++k) EXPECT_EQ(halves.feature[k], full.feature[k]);
      EXPECT_EQ(halves.transmittance, full.transmittance);
      EXPECT_EQ(halves.distance, full.distance);
    }
    const ParticleBuffers all(device, set, paper_options());
    const std::size_t sh_rows = static_cast<std::size_t>(set.params.cols()) - SIM_SH;
    EXPECT_EQ(all.params.count() - buffers.params.count(), sh_rows * buffers.stride / 2);
  }
}

TEST(ShStorage, WhatHalvesCannotHoldIsRefused) {
  const Device& device = test::device();
  GaussianSet set = crowd(test::kCameraSh3, 20);
  RenderOptions options = paper_options();
  options.sh_storage = ShStorage::kHalf;
  options.precision = Precision::kDouble;
  expect_error(ErrorKind::kUsage, "allowed full", [&] { ParticleBuffers(device, set, options); });
  options.precision = Precision::kFloat;
  set.sh(3).row(1).setConstant(-65504.0F);
  (void)ParticleBuffers(device, set, options);
  set.sh(3).row(1).setConstant(-70000.0F);
  expect_error(ErrorKind::kUsage, "allowed at most 65504", [&] { ParticleBuffers(device, set, options); });
}

TEST(ShutterOf0, IsAFrameHalfWay) {
  const Device& device = test::device();
  RenderOptions options = paper_options();
  options.shutter_iterations = 0;
  for (const SceneCase& scene : {test::kCameraRolling, test::kLidarMoving}) {
    test::Shot shot = shot_for(scene);
    const RayResults found = render(device, crowd(scene), shot, options);
    View& v = shot.view;
    EXPECT_NE(found.transmittance, render(device, crowd(scene), shot, paper_options()).transmittance);
    v.scene_from_sensor_start = v.scene_from_sensor_end =
        interpolate(v.scene_from_sensor_start, v.scene_from_sensor_end, 0.5);
    EXPECT_EQ(found.transmittance, render(device, crowd(scene), shot, paper_options()).transmittance);
  }
}

TEST(PicturesOnly, HaveNoGradients) {
  const Device& device = test::device();
  const test::Shot shot = shot_for(test::kCameraSh3);
  const GaussianSet set = crowd(test::kCameraSh3, 40);
  RenderOptions options = paper_options();
  EXPECT_NO_THROW(need_gradients(options, "test"));
  options.sh_direction = ShDirection::kRay;
  EXPECT_THROW(need_gradients(options, "test"), Error);
  Renderer renderer(device, options);
  const SensorRays rays = shot.on(device, options);
  const ParticleBuffers particles(device, set, options);
  Pass pass = renderer.render(particles, rays, shot.view);
  RealBuffer grads(device, "gradients", Precision::kFloat);
  expect_error(ErrorKind::kUsage, "nothing else has gradients", [&] { pass.backward(particles, grads); });
}

}  // namespace render_per_ray_test
}  // namespace simuli

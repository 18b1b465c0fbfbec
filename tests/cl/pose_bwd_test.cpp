// The gradient of a sensor's pose against differences of the forward pass, in double.
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "tests/cl/support.hpp"

namespace simuli {
namespace {

// Quotients are accurate to some 1e-9: h^4 f''''' after extrapolation, and 1e-16 |L| / h of rounding.
constexpr double kTolerance = 1e-6;
constexpr double kStep = 1e-4;

class PoseGradientOf : public testing::TestWithParam<test::SceneCase> {};

TEST_P(PoseGradientOf, MatchesDifferences) {
  const test::SceneCase& scene = GetParam();
  const Device device = Device::best();
  SIMULI_NEEDS_DOUBLE(device);
  const bool camera = scene.kind == SetKind::kCamera;
  RenderOptions options = paper_options();
  options.precision = Precision::kDouble;
  options.alpha_cut = 1e-12;  // no contribution comes or goes visibly when the sensor moves
  options.transmittance_cut = 0.0;
  test::SetRecipe recipe;
  recipe.count = 24;
  recipe.low = camera ? Eigen::Vector3d(4, -2, -1.5) : Eigen::Vector3d(4, -7, -2.5);
  recipe.high = camera ? Eigen::Vector3d(9, 2, 1.5) : Eigen::Vector3d(9, 7, 1.0);
  recipe.scale_min = 0.2;
  recipe.scale_max = 0.7;
  recipe.opacity_min = 0.2;
  recipe.opacity_max = 0.9;
  recipe.sh_spread = 0.2;
  GaussianSet set = test::set_for(scene, recipe, 5);
  set.sh(0).array() += 1.5F;
  const test::Shot shot = camera ? test::shot_of(scene, 24, 20) : test::shot_of(scene, 60, 12);
  Renderer renderer(device, options);
  const SensorRays rays = shot.on(device, options);
  const ParticleBuffers particles(device, set, options.precision);
  std::vector<double> weights(std::size_t{5} * rays.grid().frame.slots);
  test::Random random(11);
  for (double& w : weights) w = random.normal();

  const auto loss_at = [&](int axis, double step) {
    PoseTangent tangent;
    (axis < 3 ? tangent.translation : tangent.rotation)(axis % 3) = step;
    View view = shot.view;
    std::tie(view.scene_from_sensor_start, view.scene_from_sensor_end) =
        moved_by(tangent, shot.view.scene_from_sensor_start, shot.view.scene_from_sensor_end);
    Pass pass = renderer.render(particles, rays, view);
    const std::vector<double> out = test::outputs(pass);
    double loss = 0.0;
    for (std::size_t i = 0; i < out.size(); ++i) loss += weights[i] * out[i];
    return loss;
  };
  std::vector<double> quotients;
  for (int axis = 0; axis < 6; ++axis) {
    const auto central = [&](double h) { return (loss_at(axis, h) - loss_at(axis, -h)) / (2.0 * h); };
    quotients.push_back((4.0 * central(0.5 * kStep) - central(kStep)) / 3.0);
  }

  Pass pass = renderer.render(particles, rays, shot.view);
  pass.set_output_gradients(test::by_ray(pass.rays(), weights));
  RealBuffer plain(device, "gradients", options.precision), grads(device, "gradients", options.precision);
  pass.backward(particles, plain);
  pass.backward(particles, grads, {.errors = false, .ray_gradients = true});
  const std::vector<double> of_plain = plain.download_double(), of_both = grads.download_double();
  for (std::size_t i = 0; i < of_plain.size(); ++i) {
    if (i % particles.stride >= particles.count) continue;  // behind the last particle nothing is written
    EXPECT_EQ(of_plain[i], of_both[i]) << i;                // of the particles: the same bits
  }
  const PoseGradient found = pass.pose_gradient(grads);
  double scale[2] = {0.0, 0.0};
  for (int axis = 0; axis < 6; ++axis) {
    scale[axis / 3] = std::max(scale[axis / 3], std::abs(quotients[static_cast<std::size_t>(axis)]));
  }
  for (int axis = 0; axis < 6; ++axis) {
    const double analytic = axis < 3 ? found.translation(axis) : found.rotation(axis - 3);
    EXPECT_NEAR(analytic, quotients[static_cast<std::size_t>(axis)], kTolerance * scale[axis / 3]) << axis;
    EXPECT_GT(std::abs(analytic), 1e-3 * scale[axis / 3]) << axis;  // every axis is felt
  }
}

INSTANTIATE_TEST_SUITE_P(All,
                         PoseGradientOf,
                         testing::Values(test::kCameraSh3, test::kCameraRolling, test::kLidarMoving),
                         [](const auto& instance) { return std::string(instance.param.name); });

TEST(PoseGradientShape, GpuLanesGiveTheSame) {
  const Device device = Device::best();
  const GaussianSet set = test::set_for(test::kLidarMoving, {.count = 400, .scale_min = 0.1}, 5);
  const test::Shot shot = test::shot_of(test::kLidarMoving, 60, 12);
  const auto gradient = [&](const LaneShape& shape) {
    RenderOptions options = paper_options();
    options.shape = shape;
    Renderer renderer(device, options);
    const SensorRays rays = shot.on(device, options);
    const ParticleBuffers particles(device, set, options.precision);
    Pass pass = renderer.render(particles, rays, shot.view);
    std::vector<double> weights(std::size_t{5} * rays.grid().frame.slots);
    test::Random random(3);
    for (double& w : weights) w = random.normal();
    pass.set_output_gradients(test::by_ray(pass.rays(), weights));
    RealBuffer grads(device, "gradients", options.precision);
    pass.backward(particles, grads, {.errors = false, .ray_gradients = true});
    return pass.pose_gradient(grads);
  };
  const PoseGradient cpu = gradient(test::kCpuShape), gpu = gradient(test::kGpuShape);
  // Sums of some ten thousand float terms in another order.
  EXPECT_LE((cpu.rotation - gpu.rotation).norm(), 1e-3 * cpu.rotation.norm());
  EXPECT_LE((cpu.translation - gpu.translation).norm(), 1e-3 * cpu.translation.norm());
}

}  // namespace
}  // namespace simuli

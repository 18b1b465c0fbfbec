// Tests the reconstruction errors that weight relocation.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <string>
#include <vector>

#include "host/device/render/train/densify.hpp"
#include "tests/cl/support.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

double sigma_of(double logit) { return 1.0 / (1.0 + std::exp(-logit)); }

/// Tests sums of errors per particle: with the errors as dL/d(first feature), the gradient of this feature.
class BlendedError : public testing::TestWithParam<LaneShape> {};

TEST_P(BlendedError, IsTheGradientOfAFeatureSeenWithThoseErrors) {
  const Device& device = test::device();
  RenderOptions options = paper_options();
  options.shape = GetParam();
  const test::SceneCase& scene = test::kCameraStill;
  GaussianSet set = test::set_for(scene, {.count = 300}, 3);
  set.sh(0).array() += 4.0F;  // clear of the clamp at 0
  const test::Shot shot = test::shot_of(scene, 70, 50);
  Renderer renderer(device, options);
  const SensorRays rays = shot.on(device, options);
  const ParticleBuffers particles(device, set, Precision::kFloat);
  RealBuffer grads(device, "gradients", Precision::kFloat);
  Pass pass = renderer.render(particles, rays, shot.view);

  // Ground truth with a known error at each pixel, equal in all channels; one row of pixels is unknown.
  const std::size_t slots = pass.frame().slots;
  std::vector<double> out = test::outputs(pass), truth(3 * slots), errors(slots);
  const std::vector<double> directions = pass.buffers().rays.world_ray.download_double();
  test::Random random(2);
  for (std::size_t i = 0; i < slots; ++i) {
    const bool is_ray =
        directions[i] != 0.0 || directions[slots + i] != 0.0 || directions[2 * slots + i] != 0.0;
    const bool known = i / 16 % 16 != 3;
    const double off = 0.25 * static_cast<double>(i % 7);
    for (std::size_t c = 0; c < 3; ++c) truth[c * slots + i] = out[c * slots + i] + (c == 1 ? -off : off);
    if (!known) truth[i] = -1.0;
    errors[i] = is_ray && truth[i] >= 0.0 ? off : 0.0;
  }
  RealBuffer truth_buffer(device, "truth", Precision::kFloat);
  truth_buffer.assign(std::span<const double>(truth));
  DensifyStage densify(device, Precision::kFloat);
  densify.pixel_error(pass.frame(), pass.buffers().rays, pass.picture(), truth_buffer, pass.ray_error());
  const std::vector<double> found_errors = pass.gradients().ray_error.download_double();
  for (std::size_t i = 0; i < slots; ++i) ASSERT_NEAR(found_errors[i], errors[i], 1e-5) << i;

  std::vector<double> output_gradients(5 * slots, 0.0);
  std::copy(found_errors.begin(), found_errors.end(), output_gradients.begin());
  pass.set_output_gradients(test::by_ray(pass.rays(), output_gradients));
  pass.backward(particles, grads, {.errors = true});
  RealBuffer accumulated(device, "errors", Precision::kFloat, particles.count);
  accumulated.fill(2.0);
  densify.accumulate(pass.frame(), pass.buffers(), pass.gradients(), accumulated);
  const std::vector<double> found = accumulated.download_double(), gradient = grads.download_double();
  const std::vector<std::uint32_t> keys = pass.buffers().projected.keys.download();
  double most = 0.0;
  for (std::size_t i = 0; i < particles.count; ++i) {
    const double expected =
        keys[i] == 0xffffffffU ? 0.0 : gradient[kShRow * particles.stride + i] / static_cast<double>(kSh0);
    EXPECT_NEAR(found[i] - 2.0, expected, 1e-5 * (1.0 + expected)) << i;
    most = std::max(most, expected);
  }
  EXPECT_GT(most, 1.0);
}

INSTANTIATE_TEST_SUITE_P(Shapes,
                         BlendedError,
                         testing::Values(test::kDefaultShape, test::kGpuShape),
                         [](const auto& pair) {
                           return std::string(pair.param.lanes == 0 ? "device" : "gpu");
                         });

TEST(BeamError, WeighsDistanceIntensityAndDropAsTheLossDoes) {
  const Device& device = test::device();
  const RenderOptions options = paper_options();
  const GaussianSet set = test::set_for(test::kLidarStill, {.count = 500}, 3);
  const test::Shot shot = test::shot_of(test::kLidarStill, 64, 16);
  Renderer renderer(device, options);
  const SensorRays rays = shot.on(device, options);
  const ParticleBuffers particles(device, set, Precision::kFloat);
  Pass pass = renderer.render(particles, rays, shot.view);
  const std::size_t slots = pass.frame().slots;
  std::vector<double> truth(2 * slots);
  for (std::size_t i = 0; i < slots; ++i) {
    truth[i] = i % 5 == 0 ? 0.0 : i % 7 == 0 ? -1.0 : 3.0 + 0.01 * static_cast<double>(i % 400);
    truth[slots + i] = 0.001 * static_cast<double>(i % 1000);
  }
  RealBuffer truth_buffer(device, "truth", Precision::kFloat);
  truth_buffer.assign(std::span<const double>(truth));
  DensifyStage densify(device, Precision::kFloat);
  densify.beam_error(pass.frame(),
                     pass.buffers().rays,
                     pass.buffers().blended,
                     truth_buffer,
                     {0.5, 0.1, 0.05},
                     pass.ray_error());
  const std::vector<double> out = test::outputs(pass);
  const std::vector<double> directions = pass.buffers().rays.world_ray.download_double();
  const std::vector<double> found = pass.gradients().ray_error.download_double();
  std::size_t counted = 0, transparent = 0;
  for (std::size_t i = 0; i < slots; ++i) {
    const bool is_ray =
        directions[i] != 0.0 || directions[slots + i] != 0.0 || directions[2 * slots + i] != 0.0;
    double expected = 0.0;
    if (is_ray && truth[i] >= 0.0) {
      ++counted;
      const double drop = sigma_of(out[2 * slots + i] - out[slots + i]);
      expected = 0.05 * (truth[i] > 0.0 ? drop : 1.0 - drop);
      if (truth[i] > 0.0) {
        const double opacity = 1.0 - out[3 * slots + i];
        const double off = opacity > 0.0 ? std::abs(out[4 * slots + i] / opacity - truth[i]) : 1.0;
        transparent += opacity > 0.0 ? 0U : 1U;
        expected += 0.5 * std::min(off, 1.0) + 0.1 * std::abs(out[i] - truth[slots + i]);
      }
    }
    // 24 bits of a distance divided by an opacity as small as 1/255.
    ASSERT_NEAR(found[i], expected, 2e-4) << i;
  }
  EXPECT_GT(counted, 500U);
  EXPECT_GT(transparent, 0U);
}

}  // namespace
}  // namespace simuli

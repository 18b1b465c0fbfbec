// Tests the largest weight of each particle against gradients ray by ray.
#include <algorithm>
#include <bit>
#include <gtest/gtest.h>
#include <vector>

#include "tests/cl/support.hpp"
#include "tests/host/expect_error.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

std::vector<float> largest_weights(Pass& pass, const Device& device, std::size_t count) {
  Buffer<std::uint32_t> largest(device, "largest", count);
  largest.fill(0);
  pass.raise_largest_weights(largest);
  std::vector<float> out;
  for (const std::uint32_t bits : largest.download()) out.push_back(std::bit_cast<float>(bits));
  return out;
}

/// dL/d(a feature's SH of degree 0) is kSh0 times the weights of the rays in L.
TEST(LargestWeight, IsThatOfTheRayThatSeesMostOfAParticle) {
  const Device& device = test::device();
  for (const test::SceneCase& scene : {test::kLidarStill, test::kLidarMoving}) {
    Renderer renderer(device, {});
    const test::Shot shot = test::shot_of(scene, 24, 6);
    const SensorRays rays = shot.on(device, {});
    const GaussianSet set = test::set_for(scene, {.count = 60, .scale_min = 0.3, .scale_max = 1.5}, 3);
    const ParticleBuffers particles(device, set, Precision::kFloat);
    RealBuffer grads(device, "gradients", Precision::kFloat);
    const std::size_t count = rays.grid().rays;
    std::vector<float> expected(60, 0.0F);
    for (std::size_t ray = 0; ray < count; ++ray) {
      Pass pass = renderer.render(particles, rays, shot.view);
      std::vector<double> one(5 * count, 0.0);
      one[count + ray] = 1.0;  // the second feature, which is not clamped
      pass.set_output_gradients(one);
      pass.backward(particles, grads);
      const std::vector<float> g = grads.download_float();
      for (std::size_t i = 0; i < expected.size(); ++i) {
        expected[i] = std::max(expected[i], g[(kShRow + 1) * particles.stride + i] / kSh0);
      }
    }
    Pass pass = renderer.render(particles, rays, shot.view);
    const std::vector<float> found = largest_weights(pass, device, expected.size());
    std::size_t seen = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_NEAR(found[i], expected[i], 1e-5F) << i;
      seen += found[i] > 0.01F ? 1 : 0;
    }
    EXPECT_GT(seen, 10U);
    EXPECT_LT(*std::min_element(found.begin(), found.end()), 0.01F);
  }
}

TEST(LargestWeight, OnlyRises) {
  const Device& device = test::device();
  Renderer renderer(device, {});
  const test::Shot shot = test::shot_of(test::kLidarStill, 24, 6);
  const SensorRays rays = shot.on(device, {});
  const ParticleBuffers particles(
      device, test::set_for(test::kLidarStill, {.count = 40}, 3), Precision::kFloat);
  Pass pass = renderer.render(particles, rays, shot.view);
  const std::vector<float> fresh = largest_weights(pass, device, 40);
  Buffer<std::uint32_t> largest(device, "largest", 40);
  largest.fill(std::bit_cast<std::uint32_t>(0.25F));
  pass.raise_largest_weights(largest);
  const std::vector<std::uint32_t> raised = largest.download();
  for (std::size_t i = 0; i < 40; ++i) {
    EXPECT_EQ(std::bit_cast<float>(raised[i]), std::max(fresh[i], 0.25F));
  }
  Buffer<std::uint32_t> too_few(device, "largest", 39);
  expect_error(ErrorKind::kUsage, "found 39 weights, allowed one for each", [&] {
    pass.raise_largest_weights(too_few);
  });
}

}  // namespace
}  // namespace simuli

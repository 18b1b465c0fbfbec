// The peer of `simuli bench --peers` must see what our most accurate order and extents see.
#include "bench/peers/peers.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <ostream>
#include <vector>

#include "tests/cl/support.hpp"

namespace simuli {
namespace {

using test::SceneCase;

class Peers : public testing::TestWithParam<SceneCase> {};

TEST_P(Peers, SeeTheSame) {
  const SceneCase scene = GetParam();
  const Device device = Device::best();
  // So many on a ray that windows fill and rays go on.
  const test::SetRecipe recipe{.count = 2000,
                               .low = {-12, -12, -4},
                               .high = {12, 12, 4},
                               .scale_min = 0.05,
                               .scale_max = 0.8,
                               .opacity_max = 0.5};
  const GaussianSet set = test::set_for(scene, recipe, 7);
  const bool camera = scene.kind == SetKind::kCamera;
  const test::Shot shot = camera ? test::shot_of(scene, 75, 50) : test::shot_of(scene, 150, 19);
  RenderOptions options;
  options.extent = Extent::kExact;
  options.order = Order::kPerRay;
  Renderer renderer(device, options);
  const SensorRays rays = shot.on(device, options);
  const ParticleBuffers particles(device, set, options.precision);
  const RayResults ours = renderer.render(particles, rays, shot.view).results();
  RayResults theirs;
  try {
    theirs = bench::traced_results(set, rays, shot.view, options);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kDevice) throw;
    GTEST_SKIP() << "not run: " << error.what();
  }

  ASSERT_EQ(theirs.rays, ours.rays);
  double transmittance = 0.0, distance_m = 0.0;
  for (std::size_t i = 0; i < ours.rays; ++i) {
    transmittance = std::max(transmittance,
                             std::abs(static_cast<double>(theirs.transmittance[i] - ours.transmittance[i])));
    distance_m = std::max(distance_m, std::abs(static_cast<double>(theirs.distance[i] - ours.distance[i])));
  }
  // Alone a response at the cut (1/255) that rounding decides otherwise.
  EXPECT_LT(transmittance, 0.005);
  EXPECT_LT(distance_m, 0.1);
  EXPECT_GT(bench::picture_psnr_db(theirs, ours), 60.0);
  if (camera) return;
  const std::vector<double> apart_m = bench::distance_differences(theirs, ours);
  ASSERT_GT(apart_m.size(), ours.rays / 3);
  EXPECT_LT(apart_m[apart_m.size() / 2], 1e-5);
  EXPECT_LT(apart_m[apart_m.size() * 99 / 100], 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Sensors,
                         Peers,
                         testing::Values(test::kCameraSh3, test::kCameraRolling, test::kLidarMoving),
                         [](const auto& scene) { return scene.param.name; });

}  // namespace
}  // namespace simuli

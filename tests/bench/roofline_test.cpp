// What a stage is said to do, against what can be counted by hand.
#include "bench/render/roofline.hpp"

#include <gtest/gtest.h>

#include "host/device/render/scene/renderer.hpp"
#include "tests/cl/support.hpp"

namespace simuli::bench {
namespace {

/// Rays that see anything of the only particle are those that it changes.
TEST(Roofline, AParticleChangesTheRaysThatSeeIt) {
  const Device device = Device::best();
  for (const test::SceneCase& scene : {test::kCameraStill, test::kLidarMoving}) {
    const test::Shot shot = test::shot_of(scene, 48, 32);
    std::uint64_t all_seeing = 0;
    for (std::uint64_t seed = 1; seed < 9; ++seed) {
      const GaussianSet set = test::set_for(scene, {.count = 1, .scale_min = 0.5, .scale_max = 0.5}, seed);
      const ParticleBuffers particles(device, set, Precision::kFloat);
      const auto expect = [&](const LaneShape& shape, std::uint64_t& seeing) {
        RenderOptions options;
        options.shape = shape;
        Renderer renderer(device, options);
        const SensorRays rays = shot.on(device, options);
        const Pass pass = renderer.render(particles, rays, shot.view);
        const RayResults results = pass.results();
        seeing = 0;
        for (const double t : results.transmittance) seeing += t < 1.0 ? 1 : 0;
        return count_visits(pass);
      };
      std::uint64_t seeing = 0, seeing_in_vectors = 0;
      const Visits one_by_one = expect({1, 1, 256}, seeing);
      EXPECT_EQ(one_by_one.changed, seeing) << seed;
      EXPECT_GE(one_by_one.looked, seeing) << seed;
      const Visits by_vector = expect({8, 32, 1}, seeing_in_vectors);
      EXPECT_EQ(seeing_in_vectors, seeing) << seed;
      EXPECT_GE(8 * by_vector.changed, seeing) << seed;
      EXPECT_LE(by_vector.changed, seeing) << seed;
      EXPECT_GE(by_vector.looked, by_vector.changed) << seed;
      all_seeing += seeing;
    }
    EXPECT_GT(all_seeing, 20U);
  }
}

/// Twice the particles: twice the work of what is by particle, and rays as before.
TEST(Roofline, WorkFollowsTheScene) {
  const Device device = Device::best();
  const test::Shot shot = test::shot_of(test::kCameraStill, 64, 48);
  Renderer renderer(device, {});
  const SensorRays rays = shot.on(device, {});
  const auto work_of = [&](std::int64_t count) {
    const GaussianSet set =
        test::set_for(test::kCameraStill, {.count = count, .scale_min = 0.01, .scale_max = 0.02}, 3);
    const ParticleBuffers particles(device, set, Precision::kFloat);
    return stage_work(renderer.render(particles, rays, shot.view));
  };
  const auto one = work_of(2000), two = work_of(4000);
  for (const char* stage : {"project", "project_backward", "sort", "blend", "blend_backward", "bin"}) {
    EXPECT_GT(two.at(stage).gbyte, one.at(stage).gbyte) << stage;
  }
  EXPECT_NEAR(two.at("project").gflop / one.at("project").gflop, 2.0, 0.2);
  EXPECT_LT(two.at("blend").gbyte, 1.9 * one.at("blend").gbyte);
  EXPECT_GT(two.at("blend").gflop, 1.5 * one.at("blend").gflop);
  EXPECT_EQ(one.at("sort").gflop, 0.0);
}

TEST(Roofline, PeaksAreThoseOfADevice) {
  DeviceOptions options;
  options.profiling = true;
  const Peak peak = measure_peak(Device::best({}, options));
  EXPECT_GT(peak.gflop_s, 0.5);
  EXPECT_GT(peak.gbyte_s, 0.2);
  EXPECT_LT(peak.gflop_s, 1e6);
  EXPECT_LT(peak.gbyte_s, 1e5);
}

}  // namespace
}  // namespace simuli::bench

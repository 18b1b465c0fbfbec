// Tests extremes of number, opacity, motion and size; degenerate_test.cpp tests single extreme particles,
// `simuli bench --extremes` float against double.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <vector>

#include "host/core/base/angles.hpp"
#include "tests/cl/support.hpp"
#include "tests/host/expect_error.hpp"
#include "tests/render/actor_scenes.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

using test::SceneCase;

test::Shot shot_for(const SceneCase& scene) {
  return scene.kind == SetKind::kCamera ? test::shot_of(scene, 40, 36) : test::shot_of(scene, 80, 18);
}

/// Returns `count` particles in a row ahead of the sensor, from 5 to 15 m, wide enough for the central rays
/// to intersect all.
GaussianSet queue_of(const SceneCase& scene, Eigen::Index count, float logit) {
  GaussianSet set(scene.kind, scene.sh_degree, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    set.mean()(i, 0) = 5.0F + 10.0F * static_cast<float>(i) / static_cast<float>(count);
  }
  set.log_scale().setConstant(2.0F);
  set.rotation().col(0).setOnes();
  set.opacity_logit().setConstant(logit);
  set.sh(0).setConstant(0.3F);
  return set;
}

class Stress : public testing::TestWithParam<SceneCase> {
 protected:
  RayResults render(const GaussianSet& set,
                    const test::Shot& shot,
                    const RenderOptions& options = paper_options()) {
    Renderer renderer(device_, options);
    return renderer.render(ParticleBuffers(device_, set, options), shot.on(device_, options), shot.view)
        .results();
  }
  static void expect_sane(const RayResults& r) {
    for (const auto* values : {&r.feature[0], &r.feature[1], &r.feature[2], &r.distance}) {
      for (const float v : *values) ASSERT_TRUE(std::isfinite(v));
    }
    for (const float t : r.transmittance) {
      ASSERT_GE(t, 0.0F);
      ASSERT_LE(t, 1.0F);
    }
  }
  Device device_ = test::device();
};

TEST_P(Stress, TenThousandOnOneRay) {
  constexpr double kRelative = 2e-4;  // of thousands of products, each rounded to 6e-8
  for (const bool alike : {false, true}) {
    for (const Order order : {Order::kRange, Order::kWindow, Order::kPerRay}) {
      constexpr Eigen::Index count = 10'000;
      GaussianSet set = queue_of(GetParam(), count, std::log(0.0005F / 0.9995F));
      if (alike) set.mean().col(0).setConstant(8.0F);
      RenderOptions options = paper_options();
      options.order = order;
      options.alpha_cut = 1e-4;
      const RayResults found = render(set, shot_for(GetParam()), options);
      expect_sane(found);
      // In the centre alpha is the opacity.
      const double darkest = std::pow(1.0 - 0.0005, static_cast<double>(count));
      const auto least = std::min_element(found.transmittance.begin(), found.transmittance.end());
      EXPECT_NEAR(static_cast<double>(*least), darkest, 0.02 * darkest) << alike;
      if (!device_.info().fp64) continue;
      options.precision = Precision::kDouble;
      const RayResults precise = render(set, shot_for(GetParam()), options);
      std::size_t apart = 0;
      for (std::size_t i = 0; i < found.rays; ++i) {
        apart += std::abs(found.transmittance[i] - precise.transmittance[i]) > kRelative ? 1U : 0U;
      }
      EXPECT_LE(apart, found.rays / 50) << alike;  // rays at the cut of alpha
    }
  }
}

TEST_P(Stress, OpacitiesToTheLastBit) {
  const float largest = std::numeric_limits<float>::max(),
              denormal = std::numeric_limits<float>::denorm_min();
  for (const float logit : {-largest, -88.0F, -5.5413F, -denormal, 0.0F, denormal, 16.7F, 88.0F, largest}) {
    const RayResults found = render(queue_of(GetParam(), 1, logit), shot_for(GetParam()));
    expect_sane(found);
    const double opacity = std::min(1.0 / (1.0 + std::exp(-static_cast<double>(logit))), 0.999);
    const double least =
        static_cast<double>(*std::min_element(found.transmittance.begin(), found.transmittance.end()));
    // Logits of 1e35 and beyond are invalid: such particles are culled.
    const double expected = std::abs(logit) >= 1e35F || opacity < 1.0 / 255.0 ? 1.0 : 1.0 - opacity;
    EXPECT_NEAR(least, expected, 0.01) << logit;
  }
}

TEST_P(Stress, MotionsOfAllKinds) {
  const test::SetRecipe recipe{.count = 200, .low = {-8, -8, -3}, .high = {8, 8, 3}};
  const GaussianSet set = test::set_for(GetParam(), recipe, 3);
  test::Shot shot = shot_for(GetParam());
  const Pose start = shot.view.scene_from_sensor_start;
  struct Motion {
    double turned_rad, driven_m;
  };
  // 1000 degrees/s for 0.1 s, half a revolution, 100 m/s for a second, nearly at rest.
  for (const Motion& m :
       {Motion{100.0 * kPi / 180.0, 3.0}, {kPi, 0.0}, {0.1, 100.0}, {1e-8, 1e-8}, {0.0, 0.0}}) {
    Pose end = start;
    end.rotation =
        Eigen::AngleAxisd(m.turned_rad, Eigen::Vector3d(0.1, 0.2, 0.97).normalized()) * start.rotation;
    end.translation += m.driven_m * Eigen::Vector3d(0.9, 0.3, 0.3);
    shot.view.scene_from_sensor_end = end;
    const RayResults found = render(set, shot);
    expect_sane(found);
    if (!device_.info().fp64) continue;
    RenderOptions options = paper_options();
    options.precision = Precision::kDouble;
    const RayResults precise = render(set, shot, options);
    std::size_t apart = 0;
    for (std::size_t i = 0; i < found.rays; ++i) {
      apart += std::abs(found.transmittance[i] - precise.transmittance[i]) > 5e-3F ? 1U : 0U;
    }
    EXPECT_LE(apart, found.rays / 50) << m.turned_rad << " rad, " << m.driven_m << " m";
  }
}

TEST_P(Stress, PosesThatAreNoNumbersAreRefused) {
  const GaussianSet set = queue_of(GetParam(), 20, 1.0F);
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    test::Shot shot = shot_for(GetParam());
    shot.view.scene_from_sensor_end.translation.y() = bad;
    expect_error(ErrorKind::kNumeric, "pose", [&] { static_cast<void>(render(set, shot)); });
    shot = shot_for(GetParam());
    shot.view.scene_from_sensor_start.rotation.x() = bad;
    expect_error(ErrorKind::kNumeric, "pose", [&] { static_cast<void>(render(set, shot)); });
  }
  test::Shot shot = shot_for(GetParam());
  shot.view.scene_from_sensor_start.rotation.coeffs().setZero();
  expect_error(ErrorKind::kNumeric, "pose", [&] { static_cast<void>(render(set, shot)); });
}

INSTANTIATE_TEST_SUITE_P(All,
                         Stress,
                         testing::Values(test::kCameraRolling, test::kLidarMoving),
                         [](const auto& pair) { return std::string(pair.param.name); });

// Inputs of a picture besides particles and poses: extremes give finite results, NaN is rejected.
TEST(StressOfLooks, EnvironmentsAndGrids) {
  const Device& device = test::device();
  const GaussianSet set = queue_of(test::kCameraRolling, 20, 1.0F);
  const test::Shot shot = shot_for(test::kCameraRolling);
  Renderer renderer(device, paper_options());
  const ParticleBuffers particles(device, set, renderer.options());
  const SensorRays rays = shot.on(device, renderer.options());
  EnvironmentMap map{4, 2, std::vector<float>(24, 0.5F)};
  ColorGrids grid = ColorGrids::identity(2, 2, 2, {{"camera", 0.0}});
  constexpr float kInf = std::numeric_limits<float>::infinity();
  constexpr float kDenormal = 1e-42F;
  for (const float value : {0.0F, kDenormal, -kDenormal, -1e20F, 1e20F}) {
    map.texels[7] = map.texels[13] = value;
    map.texels[10] = -value;
    const EnvironmentBuffers environment(device, map, Precision::kFloat);
    for (const float gain : {kDenormal, 1e10F, -1e10F}) {
      for (std::size_t i = 0; i < grid.values.size(); i += 5) grid.values[i] = gain;
      Pass pass = renderer.render(particles, rays, shot.view, &environment);
      pass.grade(ColorGridBuffers(device, grid, Precision::kFloat), 0);
      const RayResults found = pass.results();
      for (const auto& channel : found.feature) {
        for (const float v : channel) ASSERT_TRUE(std::isfinite(v)) << value << ' ' << gain;
      }
    }
  }
  for (const float bad : {std::nanf(""), kInf, -kInf, 2e20F}) {
    map.texels[7] = bad;
    expect_error(ErrorKind::kNumeric, "environment map: found", [&] {
      EnvironmentBuffers(device, map, Precision::kFloat);
    });
    grid.values[3] = bad;
    expect_error(ErrorKind::kNumeric, "colour grid: found", [&] {
      ColorGridBuffers(device, grid, Precision::kFloat);
    });
  }
}

TEST(StressOfActors, PosesThatAreNoNumbersAreRefused) {
  const Device& device = test::device();
  GaussianSet set = queue_of(test::kCameraRolling, 20, 1.0F);
  set.actor.assign(20, 1);
  const test::Shot shot = shot_for(test::kCameraRolling);
  Renderer renderer(device, paper_options());
  const ParticleBuffers particles(device, set, renderer.options());
  const SensorRays rays = shot.on(device, renderer.options());
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), 1e8}) {
    test::Shot broken = shot;
    broken.view.actors = test::cars(0.1, 0.01);
    broken.view.actors[0].scene_from_actor_end.translation.z() = bad;
    expect_error(
        ErrorKind::kNumeric, "pose of actor 0", [&] { renderer.render(particles, rays, broken.view); });
    broken.view.actors = test::cars(0.1, 0.01);
    broken.view.actors[1].scene_from_actor_start.rotation.coeffs().setConstant(bad);
    expect_error(
        ErrorKind::kNumeric, "pose of actor 1", [&] { renderer.render(particles, rays, broken.view); });
  }
  test::Shot broken = shot;
  broken.view.actors = test::cars(0.1, 0.01);
  broken.view.actors[0].scene_from_actor_start.rotation.coeffs().setZero();
  expect_error(
      ErrorKind::kNumeric, "pose of actor 0", [&] { renderer.render(particles, rays, broken.view); });
  // An absent actor may have any pose.
  broken.view.actors[0].is_there = false;
  Pass pass = renderer.render(particles, rays, broken.view);
}

TEST(HugePictures, AreRefusedBeforeAnythingIsAllocated) {
  const Device& device = test::device();
  Camera camera;
  camera.name = "huge";
  camera.fx = camera.fy = 10000.0;
  camera.width = camera.height = 16384;
  // Enlarged until the device rejects it.
  while (static_cast<double>(camera.width) * camera.height * 84.0 <=
         static_cast<double>(device.info().global_bytes)) {
    camera.width *= 2;
  }
  camera.cx = 0.5 * camera.width;
  camera.cy = 8192.0;
  expect_error(ErrorKind::kDevice, "x 16384 pixels", [&] { SensorRays(device, camera, paper_options()); });
}

}  // namespace
}  // namespace simuli

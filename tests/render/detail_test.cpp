// Tests that levels of detail are rendered with the share given by their distance.
#include <cmath>
#include <gtest/gtest.h>

#include "host/device/render/levels/levels.hpp"
#include "tests/cl/support.hpp"
#include "tests/render/actor_scenes.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

/// Returns the position of a particle at mid frame.
Eigen::Vector3d place_of(const GaussianSet& set, Eigen::Index i, const View& view) {
  const Eigen::Vector3d mean = set.mean().row(i).transpose().cast<double>();
  const std::uint32_t actor = set.actor.empty() ? 0U : set.actor[static_cast<std::size_t>(i)];
  if (actor == 0) return mean;
  const ActorView& its = view.actors[actor - 1];
  return interpolate(its.scene_from_actor_start, its.scene_from_actor_end, 0.5) * mean;
}

/// Applies each particle's share, from its distance, to its opacity.
GaussianSet shared_out(const DetailLevels& levels, const View& view, double reach, std::size_t& part_way) {
  const Eigen::Vector3d centre =
      interpolate(view.scene_from_sensor_start, view.scene_from_sensor_end, 0.5).translation;
  const auto faded_in = [](double range, double from) {
    return from == 0.0 ? 1.0 : std::clamp((range / from - 1.0) / (SIM_DETAIL_FADE - 1.0), 0.0, 1.0);
  };
  GaussianSet set = levels.set;
  for (Eigen::Index i = 0; i < set.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double range = (place_of(set, i, view) - centre).norm();
    const double share = faded_in(range, reach * static_cast<double>(levels.from_m[k])) *
                         (1.0 - faded_in(range, reach * static_cast<double>(levels.until_m[k])));
    if (share == 1.0) continue;
    if (share > 0.0) ++part_way;
    const double clear = 1.0 / (1.0 + std::exp(static_cast<double>(set.opacity_logit()(i))));
    const double opacity = 1.0 - std::pow(clear, share);
    set.opacity_logit()(i) = share > 0.0 ? static_cast<float>(std::log(opacity / (1.0 - opacity))) : -80.0F;
  }
  return set;
}

class DetailInFrames : public testing::TestWithParam<Precision> {};

TEST_P(DetailInFrames, IsThatOfSharesByHand) {
  const Device& device = test::device();
  if (GetParam() == Precision::kDouble) SIMULI_NEEDS_DOUBLE(device);
  const test::Tolerance tolerance =
      GetParam() == Precision::kDouble ? test::kDoubleTolerance : test::kFloatTolerance;
  for (const test::SceneCase& scene : {test::kCameraRolling, test::kLidarMoving}) {
    const bool camera = scene.kind == SetKind::kCamera;
    test::Shot shot = test::shot_of(scene, camera ? 64 : 240, camera ? 48 : 16);
    shot.view.actors = test::cars(0.4, 0.1);
    GaussianSet set = test::set_for(scene, {.count = 3000}, 11);
    // Small, dense particles, a fifth of them on two cars.
    set.log_scale().array() -= 1.5F;
    set.opacity_logit().array() -= 1.0F;
    for (Eigen::Index i = 0; i < set.size(); ++i) {
      set.actor.push_back(i % 10 < 2 ? static_cast<std::uint32_t>(1 + i % 10) : 0U);
      if (set.actor.back() > 0) set.mean().row(i) = 0.2F * set.mean().row(i);
    }
    RenderOptions options;
    options.precision = GetParam();
    options.detail = camera ? 4.0 : 8.0;
    Renderer with(device, options);
    const SensorRays rays = shot.on(device, options);
    const double reach = rays.grid().model.rays_per_rad / options.detail;
    std::size_t part_way = 0;
    const DetailLevels levels = detail_levels(set);
    const GaussianSet by_hand = shared_out(levels, shot.view, reach, part_way);
    EXPECT_GT(part_way, 20U);
    EXPECT_GT(levels.set.size(), set.size() + 50);
    ParticleBuffers particles(device, set, options);
    const std::vector<double> found = test::outputs(with.render(particles, rays, shot.view));
    // Without clusters: no visible cluster is omitted.
    particles.cluster_stride = 0;
    EXPECT_EQ(test::outputs(with.render(particles, rays, shot.view)), found);

    RenderOptions plain = options;
    plain.detail = 0.0;
    Renderer without(device, plain);
    const SensorRays same_rays = shot.on(device, plain);
    const std::vector<double> expected =
        test::outputs(without.render(ParticleBuffers(device, by_hand, GetParam()), same_rays, shot.view));
    const std::vector<double> all =
        test::outputs(without.render(ParticleBuffers(device, set, GetParam()), same_rays, shot.view));
    ASSERT_EQ(found.size(), expected.size());
    std::size_t off = 0, otherwise = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      // Sums of weights times metres are the largest outputs.
      off += std::abs(found[i] - expected[i]) > tolerance.distance_m ? 1U : 0U;
      otherwise += std::abs(all[i] - expected[i]) > tolerance.distance_m ? 1U : 0U;
    }
    // A contribution at the cut may differ.
    EXPECT_LE(off, found.size() / 1000);
    EXPECT_GT(otherwise, found.size() / 100);
  }
}

INSTANTIATE_TEST_SUITE_P(All,
                         DetailInFrames,
                         testing::Values(Precision::kFloat, Precision::kDouble),
                         [](const auto& pair) {
                           return pair.param == Precision::kFloat ? "in_float" : "in_double";
                         });

}  // namespace
}  // namespace simuli

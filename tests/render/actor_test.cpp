// Tests particles of actors against brute force, with each actor's pose at each ray's own time.
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "tests/cl/support.hpp"
#include "tests/render/actor_scenes.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

using Eigen::Vector3d;
using test::SceneCase;

constexpr SceneCase kCameraRollingSh0{"camera_rolling", SetKind::kCamera, true, false, 0};

/// Returns background around the sensor and two actors whose particles are between those of the background.
GaussianSet set_with_actors(const SceneCase& scene) {
  const bool camera = scene.kind == SetKind::kCamera;
  test::SetRecipe background{.count = 60,
                             .low = camera ? Vector3d(4, -4, -3) : Vector3d(-12, -12, -3),
                             .high = Vector3d(14, camera ? 4 : 12, camera ? 3 : 1),
                             .scale_min = 0.1,
                             .scale_max = 0.5};
  const test::SetRecipe actor{
      .count = 50, .low = {-2, -0.9, -0.7}, .high = {2, 0.9, 0.7}, .scale_min = 0.05, .scale_max = 0.3};
  const GaussianSet parts[] = {test::set_for(scene, background, 1), test::set_for(scene, actor, 2)};
  GaussianSet set(scene.kind, scene.sh_degree, 110);
  for (Eigen::Index i = 0; i < set.size(); ++i) {
    const bool of_actor = i % 2 == 1 && i / 2 < 50;
    const Eigen::Index row = of_actor ? i / 2 : i < 100 ? i / 2 : 50 + (i - 100) % 10;
    set.params.row(i) = parts[of_actor ? 1 : 0].params.row(row);
    set.actor.push_back(of_actor ? 1 + (i / 2 < 25 ? 0U : 1U) : 0U);
  }
  return set;
}

/// Returns the pose at share t of the frame (METHOD section 2).
Pose at(const ActorView& view, double t) {
  return interpolate(view.scene_from_actor_start, view.scene_from_actor_end, t);
}

/// Returns the transmittance of each ray: all particles, each in its actor's frame at the ray's own time,
/// without order and boxes.
std::vector<double> brute_transmittance(const GaussianSet& set, const test::Shot& shot, double alpha_cut) {
  const reference::Sensor sensor = shot.reference();
  const reference::Particles particles(set);
  const auto footprints = reference::project(particles, sensor, {.ignore_box = true});
  const std::vector<reference::Ray> rays = reference::rays(sensor);
  const bool camera = shot.kind == SetKind::kCamera;
  std::vector<double> out(rays.size(), 1.0);
  for (std::size_t r = 0; r < rays.size(); ++r) {
    const double t = camera ? reference::exposure_time(shot.camera, {rays[r].x, rays[r].y})
                            : static_cast<double>(shot.rays.time_fraction[r]);
    std::vector<Pose> actor_from_scene{Pose{}};
    for (const ActorView& view : shot.view.actors) actor_from_scene.push_back(at(view, t).inverse());
    for (Eigen::Index i = 0; i < set.size(); ++i) {
      const Eigen::RowVectorXd p = particles.params.row(i);
      const std::uint32_t actor = set.actor.empty() ? 0 : set.actor[static_cast<std::size_t>(i)];
      const Pose& to_actor = actor_from_scene[actor];
      const Vector3d mean = p.segment<3>(kMeanRow).transpose();
      const Vector3d origin = to_actor * rays[r].origin;
      const Vector3d direction = to_actor.rotation * rays[r].direction;
      const Eigen::Quaterniond q =
          Eigen::Quaterniond(p(kRotationRow), p(kRotationRow + 1), p(kRotationRow + 2), p(kRotationRow + 3))
              .normalized();
      // The footprint filter: its variance increases with the range at mid frame.
      const Pose middle =
          interpolate(shot.view.scene_from_sensor_start, shot.view.scene_from_sensor_end, 0.5);
      const Vector3d in_scene = actor == 0 ? mean : Vector3d(at(shot.view.actors[actor - 1], 0.5) * mean);
      const double kappa = camera ? kPixelVariance_px2 / std::pow(shot.camera.focal_px(), 2) : 0.0;
      const double widen = kappa * (in_scene - middle.translation).squaredNorm();
      const Vector3d scale = ((2.0 * p.segment<3>(kLogScaleRow).transpose().array()).exp() + widen).sqrt();
      const Eigen::Matrix3d unit_from_actor =
          scale.cwiseInverse().asDiagonal() * q.toRotationMatrix().transpose();
      const Vector3d o = unit_from_actor * (origin - mean);
      const Vector3d d = unit_from_actor * direction;
      const double tau = -o.dot(d) / d.squaredNorm();
      const double opacity = 1.0 / (1.0 + std::exp(-p(kOpacityRow)));
      const double alpha =
          std::min(opacity * std::exp(-0.5 * o.cross(d).squaredNorm() / d.squaredNorm()), 0.999);
      const double t_min = camera ? 0.01 : shot.lidar.range_min;
      const double t_max = camera ? 1e6 : shot.lidar.range_max;
      if (alpha >= alpha_cut && tau > t_min && tau < t_max) out[r] *= 1.0 - alpha;
    }
  }
  return out;
}

RenderOptions exact_options(Precision precision) {
  RenderOptions options;
  options.precision = precision;
  options.extent = Extent::kExact;
  options.transmittance_cut = 0.0;
  return options;
}

/// Largest difference of a transmittance from brute force. Rays with a contribution just at the cut may
/// differ by alpha_cut and are not compared.
struct Difference {
  double worst = 0.0;
  std::size_t on_cars = 0;  // rays that actors change
  std::size_t at_the_cut = 0;
};
Difference difference(const SceneCase& scene, double step_m, double turn_rad, Precision precision) {
  const bool camera = scene.kind == SetKind::kCamera;
  test::Shot shot = camera ? test::shot_of(scene, 64, 48) : test::shot_of(scene, 180, 24);
  shot.view.actors = test::cars(step_m, turn_rad);
  const GaussianSet set = set_with_actors(scene);
  const Device& device = test::device();
  const RenderOptions options = exact_options(precision);
  Renderer renderer(device, options);
  const SensorRays rays = shot.on(device, options);
  const RayResults results =
      renderer.render(ParticleBuffers(device, set, precision), rays, shot.view).results();
  const std::vector<double> expected = brute_transmittance(set, shot, options.alpha_cut);
  const std::vector<double> looser = brute_transmittance(set, shot, options.alpha_cut * 1.02);
  const std::vector<double> tighter = brute_transmittance(set, shot, options.alpha_cut * 0.98);
  GaussianSet background = set;
  for (Eigen::Index i = 0; i < set.size(); ++i) {
    if (set.actor[static_cast<std::size_t>(i)] > 0) background.opacity_logit()(i) = -80.0F;
  }
  const std::vector<double> without = brute_transmittance(background, shot, options.alpha_cut);
  Difference out;
  for (std::size_t r = 0; r < expected.size(); ++r) {
    out.on_cars += std::abs(without[r] - expected[r]) > 0.05 ? 1U : 0U;
    if (looser[r] != expected[r] || tighter[r] != expected[r]) {
      ++out.at_the_cut;
      continue;
    }
    out.worst = std::max(out.worst, std::abs(static_cast<double>(results.transmittance[r]) - expected[r]));
  }
  return out;
}

// Rays and results are floats (as in forward_test.cpp).
constexpr double kExact = 2e-6;

TEST(Actors, ThatDriveAreWhereEachRayMeetsThem) {
  const Device& device = test::device();
  SIMULI_NEEDS_DOUBLE(device);
  // 4 m per frame: 40 m/s in a sweep. Linear motion is rendered exactly.
  for (const SceneCase& scene : {test::kLidarMoving, kCameraRollingSh0}) {
    const Difference d = difference(scene, 4.0, 0.0, Precision::kDouble);
    EXPECT_LT(d.worst, kExact) << scene.name;
    EXPECT_GT(d.on_cars, 60U) << scene.name;
    EXPECT_LT(d.at_the_cut, 600U) << scene.name;
  }
}

TEST(Actors, ThatTurnAreOffBySecondOrder) {
  const Device& device = test::device();
  SIMULI_NEEDS_DOUBLE(device);
  // 45 degrees/s and 20 m/s in a sweep. A particle keeps the heading at its centre's time: the error is the
  // rotation between that time and a ray's time, times the particle's size.
  const Difference slow = difference(test::kLidarMoving, 2.0, 0.08, Precision::kDouble);
  const Difference fast = difference(test::kLidarMoving, 2.0, 0.16, Precision::kDouble);
  EXPECT_LT(slow.worst, 3e-3);
  EXPECT_LT(fast.worst, 6e-3);
  EXPECT_GT(fast.worst, kExact);  // otherwise nothing is tested
}

TEST(Actors, AreDrawnInFloatAsInDouble) {
  const Difference d = difference(test::kLidarMoving, 4.0, 0.0, Precision::kFloat);
  EXPECT_LT(d.worst, 3e-3);
  EXPECT_GT(d.on_cars, 60U);
}

TEST(Actors, UnderAGlobalShutterStandStill) {
  const Device& device = test::device();
  const RenderOptions options = paper_options();
  Renderer renderer(device, options);
  test::Shot shot = test::shot_of(test::kCameraStill, 64, 48);
  const GaussianSet set = set_with_actors(test::kCameraStill);
  shot.view.actors = test::cars(0.0, 0.0);
  const SensorRays rays = shot.on(device, options);
  const RayResults found =
      renderer.render(ParticleBuffers(device, set, Precision::kFloat), rays, shot.view).results();

  // The same with the particles moved to the scene on the host.
  GaussianSet placed = set;
  for (Eigen::Index i = 0; i < set.size(); ++i) {
    const std::uint32_t actor = set.actor[static_cast<std::size_t>(i)];
    if (actor == 0) continue;
    const Pose scene_from_actor = at(shot.view.actors[actor - 1], 0.5);
    placed.mean().row(i) =
        (scene_from_actor * set.mean().row(i).transpose().cast<double>()).cast<float>().transpose();
    const Eigen::RowVector4f q = set.rotation().row(i);
    const Eigen::Quaterniond turned =
        scene_from_actor.rotation * Eigen::Quaternionf(q(0), q(1), q(2), q(3)).cast<double>();
    placed.rotation().row(i) << static_cast<float>(turned.w()), static_cast<float>(turned.x()),
        static_cast<float>(turned.y()), static_cast<float>(turned.z());
  }
  placed.actor.clear();
  const RayResults expected =
      renderer.render(ParticleBuffers(device, placed, Precision::kFloat), rays, shot.view).results();
  double worst = 0.0, changed = 0.0;
  for (std::size_t r = 0; r < found.rays; ++r) {
    worst =
        std::max(worst, std::abs(static_cast<double>(found.transmittance[r] - expected.transmittance[r])));
    changed = std::max(changed, 1.0 - static_cast<double>(expected.transmittance[r]));
  }
  EXPECT_LT(worst, 5e-3);  // contributions at the cut, 1/255, depend on rounding
  EXPECT_GT(changed, 0.5);
}

TEST(Actors, ThatAreNotThereLeaveTheBackgroundsBits) {
  const Device& device = test::device();
  const RenderOptions options = paper_options();
  Renderer renderer(device, options);
  for (const double step_m : {0.0, 3.0}) {
    test::Shot shot = test::shot_of(test::kCameraRolling, 64, 48);
    const GaussianSet set = set_with_actors(test::kCameraRolling);
    shot.view.actors = test::cars(step_m, 0.05);
    shot.view.actors[1].is_there = false;
    GaussianSet without(set.kind, set.sh_degree, 0), one_gone(set.kind, set.sh_degree, 0);
    for (Eigen::Index i = 0; i < set.size(); ++i) {
      const std::uint32_t actor = set.actor[static_cast<std::size_t>(i)];
      for (GaussianSet* to : {&without, &one_gone}) {
        if (actor == 2 || (actor == 1 && to == &without)) continue;
        to->params.conservativeResize(to->size() + 1, set.params.cols());
        to->params.bottomRows(1) = set.params.row(i);
        if (to == &one_gone) to->actor.push_back(actor);
      }
    }
    const SensorRays rays = shot.on(device, options);
    const auto picture = [&](const GaussianSet& s) {
      return renderer.render(ParticleBuffers(device, s, Precision::kFloat), rays, shot.view).results();
    };
    const RayResults found = picture(set), expected = picture(one_gone);
    EXPECT_EQ(found.feature[0], expected.feature[0]);
    EXPECT_EQ(found.transmittance, expected.transmittance);
    shot.view.actors[0].is_there = false;
    const RayResults empty = picture(set), background = picture(without);
    EXPECT_EQ(empty.feature[1], background.feature[1]);
    EXPECT_EQ(empty.transmittance, background.transmittance);
    EXPECT_NE(found.transmittance, background.transmittance);
  }
}

TEST(Actors, KeepTheirParticlesInTheirBoxes) {
  const Device& device = test::device();
  GaussianSet set = set_with_actors(test::kCameraStill);
  set.mean() *= 3.0F;
  set.log_scale()(1, 0) = 2.0F;
  std::vector<Actor> actors(2);
  actors[0].size_m = {4.0, 1.8, 1.5};
  actors[1].size_m = {1.0, 0.5, 2.0};
  ParticleBuffers particles(device, set, Precision::kFloat);
  Renderer renderer(device, paper_options());
  renderer.confine(particles, actors, 0.1);
  const GaussianSet confined = particles.download();
  EXPECT_EQ(confined.actor, set.actor);
  bool moved = false;
  for (Eigen::Index i = 0; i < set.size(); ++i) {
    const std::uint32_t actor = set.actor[static_cast<std::size_t>(i)];
    if (actor == 0) {
      EXPECT_EQ(confined.params.row(i), set.params.row(i));
      continue;
    }
    const Eigen::RowVector3f half = (0.5 * actors[actor - 1].size_m.transpose()).cast<float>().array() + 0.1F;
    const Eigen::RowVector3f expected = set.mean().row(i).cwiseMin(half).cwiseMax(-half);
    EXPECT_TRUE(confined.mean().row(i).isApprox(expected, 1e-6F));
    moved = moved || !expected.isApprox(set.mean().row(i));
  }
  EXPECT_TRUE(moved);
  EXPECT_NEAR(confined.log_scale()(1, 0), std::log(0.25 * 4.0), 1e-6);
}

}  // namespace
}  // namespace simuli

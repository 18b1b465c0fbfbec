// Tests gradients of shapes of non-rigid actors and their particles against differences, and renders against
// particles moved manually.
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include "tests/cl/support.hpp"
#include "tests/render/actor_scenes.hpp"
#include "tests/render/gradient/gradient_check.hpp"
#include "tests/render/gradient/gradient_problem.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

using Eigen::Vector3d;
using test::SceneCase;

// One degree, as in other tests with actors: kernels are compiled once.
constexpr SceneCase kCamera{"camera_sh1", SetKind::kCamera, false, false, 1};
constexpr SceneCase kLidar{"lidar_sh1", SetKind::kLidar, false, false, 1};

/// Returns a shape of a box of 2 x 2 x 1.6 m with offsets of up to `largest_m`.
DeformationView shape_of(double largest_m, std::uint64_t seed) {
  DeformationView shape;
  shape.nodes = {3, 4, 2};
  shape.half_m = {1.0, 1.0, 0.8};
  test::Random random(seed);
  for (std::vector<double>* const offsets : {&shape.start_m, &shape.end_m}) {
    for (int i = 0; i < 3 * 24; ++i) offsets->push_back(random.uniform(-largest_m, largest_m));
  }
  return shape;
}

/// Two actors, the first of which is not rigid; most particles of both sets belong to them.
test::Shot shot_with_shapes(const SceneCase& scene, double largest_m) {
  const bool camera = scene.kind == SetKind::kCamera;
  test::Shot shot = camera ? test::shot_of(scene, 24, 20) : test::shot_of(scene, 60, 12);
  shot.view.actors = test::cars(0.0, 0.0);
  if (largest_m > 0.0) shot.view.actors[0].deformation = shape_of(largest_m, 3);
  return shot;
}

GaussianSet particles_for(const SceneCase& scene) {
  const test::SetRecipe recipe{.count = 15,
                               .low = {5, -2, -1},
                               .high = {9, 2, 1},
                               .scale_min = 0.3,
                               .scale_max = 0.7,
                               .opacity_min = 0.2,
                               .opacity_max = 0.9,
                               .sh_spread = 0.1};
  GaussianSet set = test::set_for(scene, recipe, 5);
  set.sh(0).array() += 1.5F;
  for (Eigen::Index i = 0; i < set.size(); ++i) {
    set.actor.push_back(static_cast<std::uint32_t>(i % 3));
    if (i % 3 != 0) set.mean().row(i) = (set.mean().row(i) - Eigen::RowVector3f(7, 0, 0)) * 0.45F;
  }
  set.mean()(4, 1) = 1.7F;  // outside the grid of the first actor
  return set;
}

/// L = sum of weight x output as a function of means and of the first actor's nodes.
class ShapeProblem {
 public:
  ShapeProblem(const SceneCase& scene, Precision precision)
      : device_(test::device()),
        options_(test::smooth_options(precision)),
        shot_(shot_with_shapes(scene, 0.4)),
        renderer_(device_, options_),
        rays_(shot_.on(device_, options_)),
        particles_(device_, particles_for(scene), precision),
        grads_(device_, "parameter gradients", precision),
        base_(particles_.params.download_double()) {
    test::Random random(11);
    weights_.resize(std::size_t{5} * rays_.grid().frame.slots);
    for (double& w : weights_) w = random.normal();
  }
  [[nodiscard]] double loss() {
    Pass pass = renderer_.render(particles_, rays_, shot_.view);
    const std::vector<double> out = test::outputs(pass);
    double loss = 0.0;
    for (std::size_t i = 0; i < out.size(); ++i) loss += weights_[i] * out[i];
    return loss;
  }
  void differentiate() {
    Pass pass = renderer_.render(particles_, rays_, shot_.view);
    pass.set_output_gradients(test::by_ray(pass.rays(), weights_));
    pass.backward(particles_, grads_);
    by_parameter = grads_.download_double();
    by_shape = pass.deformation_gradients();
  }
  [[nodiscard]] test::Quotients of_means() {
    std::vector<std::size_t> entries;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t particle = 0; particle < 15; ++particle)
        entries.push_back(axis * particles_.stride + particle);
    }
    const test::Quotients out =
        test::compare_quotients(by_parameter, entries, [&](std::size_t at, double step) {
          std::vector<double> moved = base_;
          moved[at] += step;
          particles_.params.assign(std::span<const double>(moved));
          return loss();
        });
    particles_.params.assign(std::span<const double>(base_));
    return out;
  }
  [[nodiscard]] test::Quotients of_nodes(bool at_end) {
    DeformationView& shape = shot_.view.actors[0].deformation;
    std::vector<double>& offsets = at_end ? shape.end_m : shape.start_m;
    std::vector<std::size_t> entries(offsets.size());
    std::iota(entries.begin(), entries.end(), 0U);
    const std::vector<double> before = offsets;
    const test::Quotients out = test::compare_quotients(
        at_end ? by_shape[0].end : by_shape[0].start, entries, [&](std::size_t at, double step) {
          offsets = before;
          offsets[at] += step;
          return loss();
        });
    offsets = before;
    return out;
  }

  std::vector<double> by_parameter;
  std::vector<DeformationGradient> by_shape;

 private:
  Device device_;
  RenderOptions options_;
  test::Shot shot_;
  Renderer renderer_;
  SensorRays rays_;
  ParticleBuffers particles_;
  RealBuffer grads_;
  std::vector<double> base_, weights_;
};

TEST(DeformationGradients, MatchDifferences) {
  SIMULI_NEEDS_DOUBLE(test::device());
  for (const SceneCase& scene : {kCamera, kLidar, test::kLidarMoving}) {
    SCOPED_TRACE(scene.name);
    ShapeProblem problem(scene, Precision::kDouble);
    problem.differentiate();
    ASSERT_EQ(problem.by_shape.size(), 2U);
    EXPECT_EQ(problem.by_shape[0].start.size(), 72U);
    EXPECT_TRUE(problem.by_shape[1].start.empty());
    for (const test::Quotients& found :
         {problem.of_means(), problem.of_nodes(false), problem.of_nodes(true)}) {
      EXPECT_LT(found.error, test::kGradientTolerance);
      EXPECT_GT(found.error_if_scaled, test::kGradientTolerance);  // the check would detect it
    }
  }
}

TEST(DeformationGradients, InFloatAreNearThoseInDouble) {
  SIMULI_NEEDS_DOUBLE(test::device());
  ShapeProblem exact(test::kLidarMoving, Precision::kDouble), single(test::kLidarMoving, Precision::kFloat);
  exact.differentiate();
  single.differentiate();
  double largest = 0.0, error = 0.0;
  for (std::size_t i = 0; i < 72; ++i) {
    largest = std::max(largest, std::abs(exact.by_shape[0].start[i]));
    error = std::max(error, std::abs(exact.by_shape[0].start[i] - single.by_shape[0].start[i]));
  }
  EXPECT_GT(largest, 0.0);
  EXPECT_LT(error, test::kFloatGradientTolerance * largest);
  const std::vector<double> first = single.by_shape[0].start;
  single.differentiate();
  EXPECT_EQ(first, single.by_shape[0].start);  // the same bits each time
}

/// Returns the bits of all outputs.
std::vector<double> shown(Renderer& renderer,
                          const GaussianSet& set,
                          const test::Shot& shot,
                          bool with_clusters = false) {
  const Device device = renderer.device();
  const SensorRays rays = shot.on(device, renderer.options());
  const Precision precision = renderer.options().precision;
  return test::outputs(
      with_clusters ? renderer.render(ParticleBuffers(device, set, renderer.options()), rays, shot.view)
                    : renderer.render(ParticleBuffers(device, set, precision), rays, shot.view));
}

TEST(Deformation, ShowsWhatParticlesMovedByHandShow) {
  SIMULI_NEEDS_DOUBLE(test::device());
  for (const SceneCase& scene : {kCamera, kLidar}) {
    SCOPED_TRACE(scene.name);
    Renderer renderer(test::device(), test::smooth_options(Precision::kDouble));
    test::Shot shot = shot_with_shapes(scene, 0.4);
    DeformationView& shape = shot.view.actors[0].deformation;
    shape.end_m = shape.start_m;  // constant over the frame
    GaussianSet set = particles_for(scene);
    const std::vector<double> deformed = shown(renderer, set, shot);
    for (Eigen::Index i = 1; i < set.size(); i += 3) {
      const Vector3d mean = set.mean().row(i).transpose().cast<double>();
      const Vector3d offset = deformation_at(shape.nodes, shape.half_m, shape.start_m, mean);
      set.mean().row(i) = (mean + offset).transpose().cast<float>();
    }
    const std::vector<double> rigid = shown(renderer, set, shot_with_shapes(scene, 0.0));
    ASSERT_EQ(deformed.size(), rigid.size());
    for (std::size_t i = 0; i < rigid.size(); ++i) ASSERT_NEAR(deformed[i], rigid[i], 1e-5);
  }
}

TEST(Deformation, OfZeroChangesNoBit) {
  for (const SceneCase& scene : {kCamera, test::kLidarMoving}) {
    Renderer renderer(test::device(), {});
    const GaussianSet set = particles_for(scene);
    test::Shot still = shot_with_shapes(scene, 0.1);
    DeformationView& shape = still.view.actors[0].deformation;
    std::fill(shape.start_m.begin(), shape.start_m.end(), 0.0);
    shape.end_m = shape.start_m;
    EXPECT_EQ(shown(renderer, set, still), shown(renderer, set, shot_with_shapes(scene, 0.0))) << scene.name;
    // An absent actor has no effect.
    still.view.actors[0] = ActorView{};
    test::Shot gone = still;
    gone.view.actors[0].deformation = shape_of(0.4, 1);
    EXPECT_EQ(shown(renderer, set, gone), shown(renderer, set, still)) << scene.name;
  }
}

TEST(Deformation, IsThatOfTheTimeAtWhichTheSensorLooks) {
  SIMULI_NEEDS_DOUBLE(test::device());
  // The first actor moves 0.4 m ahead during the sweep; the rays have one time.
  const SceneCase scene = kLidar;
  test::Shot shot = shot_with_shapes(scene, 0.1);
  DeformationView& shape = shot.view.actors[0].deformation;
  for (std::size_t i = 0; i < 72; ++i) {
    shape.start_m[i] = 0.0;
    shape.end_m[i] = i % 3 == 0 ? 0.4 : 0.0;
  }
  Renderer renderer(test::device(), test::smooth_options(Precision::kDouble));
  const std::vector<double> deformed = shown(renderer, particles_for(scene), shot);
  const Pose& pose = shot.view.actors[0].scene_from_actor_start;
  const Vector3d p = shot.view.scene_from_sensor_start.inverse() * pose.translation;
  const double spun = std::remainder(shot.lidar.azimuth_first - std::atan2(p.y(), p.x()), 2.0 * M_PI);
  const double turn = shot.lidar.spin == SpinDirection::kClockwise ? spun : -spun;
  const double share = (turn < 0.0 ? turn + 2.0 * M_PI : turn) / shot.lidar.azimuth_span;
  test::Shot moved = shot_with_shapes(scene, 0.0);
  for (Pose* const at :
       {&moved.view.actors[0].scene_from_actor_start, &moved.view.actors[0].scene_from_actor_end})
    at->translation += at->rotation * Vector3d(0.4 * share, 0.0, 0.0);
  const std::vector<double> rigid = shown(renderer, particles_for(scene), moved);
  double largest = 0.0;
  for (std::size_t i = 0; i < rigid.size(); ++i)
    largest = std::max(largest, std::abs(deformed[i] - rigid[i]));
  EXPECT_LT(largest, 0.02);
}

}  // namespace
}  // namespace simuli

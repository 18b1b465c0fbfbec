// Tests gradients of per-ray order against differences, and against the order by range if both agree.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "tests/cl/support.hpp"
#include "tests/render/gradient/gradient_check.hpp"
#include "tests/render/gradient/gradient_problem.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace render_window_bwd_test {

using test::GradientCheck;
using test::SceneCase;
using Problem = test::GradientProblem;

using test::kFloatGradientTolerance;
using test::kGradientTolerance;
constexpr double kStep = test::kQuotientStep;
constexpr int kCount = 60;

test::Shot shot_for(const SceneCase& scene) {
  return scene.kind == SetKind::kCamera ? test::shot_of(scene, 40, 24) : test::shot_of(scene, 90, 12);
}

/// Wide overlapping particles: the order by range often differs from the order along a ray.
GaussianSet crowd(const SceneCase& scene) {
  const test::SetRecipe recipe{.count = kCount,
                               .low = {-9, -9, -3},
                               .high = {9, 9, 3},
                               .scale_min = 0.2,
                               .scale_max = 1.8,
                               .opacity_min = 0.2,
                               .opacity_max = 0.9,
                               .sh_spread = 0.1};
  GaussianSet set = test::set_for(scene, recipe, 5);
  set.sh(0).array() += 1.5F;
  return set;
}

RenderOptions options_with(Order order,
                           int window,
                           Precision precision,
                           LaneShape shape = test::kDefaultShape) {
  RenderOptions options = test::smooth_options(precision);
  options.order = order;
  options.window = window;
  options.shape = shape;
  return options;
}

/// Returns the gradient without the padding between rows of parameters, which is never written.
std::vector<double> all_of(Problem& problem, int sh_degree, int particles) {
  const std::vector<double> gradient = problem.gradient();
  std::vector<double> out;
  for (int row = 0; row < param_rows(sh_degree); ++row) {
    for (int particle = 0; particle < particles; ++particle)
      out.push_back(gradient[problem.at(row, particle)]);
  }
  return out;
}

/// Returns |a - b| / |b|.
double apart(const std::vector<double>& a, const std::vector<double>& b) {
  double error = 0.0, size = 0.0;
  for (std::size_t i = 0; i < b.size(); ++i) {
    error += (a[i] - b[i]) * (a[i] - b[i]);
    size += b[i] * b[i];
  }
  return std::sqrt(error / size);
}

struct OrderCase {
  const char* name;
  SceneCase scene;
  Order order;
  int window;
  LaneShape shape;
};
void PrintTo(const OrderCase& c, std::ostream* out) { *out << c.name; }

class GradientByRay : public testing::TestWithParam<OrderCase> {
 protected:
  [[nodiscard]] static RenderOptions options(Precision precision) {
    const OrderCase& c = GetParam();
    return options_with(c.order, c.window, precision, c.shape);
  }
};

// Neither parameter moves the maximum of the response: the order is constant.
TEST_P(GradientByRay, OfOpacitiesAndColoursMatchesDifferences) {
  const SceneCase& scene = GetParam().scene;
  const Device& device = test::device();
  SIMULI_NEEDS_DOUBLE(device);
  SIMULI_NEEDS_WINDOWS(device, GetParam().shape);
  const GaussianSet set = crowd(scene);
  const test::Shot shot = shot_for(scene);
  Problem problem(device, shot, set, options(Precision::kDouble));
  const std::vector<double> gradient = problem.gradient();
  GradientCheck check;
  for (int particle = 0; particle < kCount; particle += 4) {
    for (const int row : {int{kOpacityRow}, int{kShRow}, kShRow + 1, kShRow + 2}) {
      const std::size_t parameter = problem.at(row, particle);
      check.add(row, gradient[parameter], problem.quotient(parameter, kStep));
    }
  }
  for (const int group : {3, 4}) {
    EXPECT_LE(check.worst(group), kGradientTolerance)
        << GradientCheck::kGroupNames[static_cast<std::size_t>(group)];
    EXPECT_TRUE(check.moves(group));
    EXPECT_FALSE(check.scaled(group, 1.01).passes(kGradientTolerance));
  }
  Problem by_range(device, shot, set, options_with(Order::kRange, 64, Precision::kDouble));
  const int degree = scene.sh_degree;
  EXPECT_GT(apart(all_of(by_range, degree, kCount), all_of(problem, degree, kCount)), 0.01)
      << "the orders do not differ";
}

TEST_P(GradientByRay, OfFloatsIsThatOfDoubles) {
  const SceneCase& scene = GetParam().scene;
  const Device& device = test::device();
  SIMULI_NEEDS_DOUBLE(device);
  SIMULI_NEEDS_WINDOWS(device, GetParam().shape);
  Problem in_double(device, shot_for(scene), crowd(scene), options(Precision::kDouble));
  Problem in_float(device, shot_for(scene), crowd(scene), options(Precision::kFloat));
  const std::vector<double> found = all_of(in_float, scene.sh_degree, kCount);
  EXPECT_LE(apart(found, all_of(in_double, scene.sh_degree, kCount)), kFloatGradientTolerance);
  EXPECT_EQ(all_of(in_float, scene.sh_degree, kCount), found);
}

INSTANTIATE_TEST_SUITE_P(
    All,
    GradientByRay,
    testing::Values(OrderCase{"camera_window", test::kCameraStill, Order::kWindow, 64, test::kCpuShape},
                    OrderCase{"camera_narrow", test::kCameraStill, Order::kWindow, 3, test::kCpuShape},
                    OrderCase{"camera_narrow_gpu", test::kCameraStill, Order::kWindow, 3, test::kGpuShape},
                    OrderCase{"camera_per_ray", test::kCameraStill, Order::kPerRay, 3, test::kCpuShape},
                    OrderCase{"lidar_window", test::kLidarMoving, Order::kWindow, 64, test::kCpuShape},
                    OrderCase{"lidar_per_ray_gpu", test::kLidarMoving, Order::kPerRay, 3, test::kGpuShape}),
    [](const auto& pair) { return std::string(pair.param.name); });

/// Wide particles beside the axis of a camera of 16 x 16 pixels with a field of view of +-2 mrad: all rays
/// have the same order, which differs from the order by range, with distances larger than the steps.
TEST(GradientInOwnOrder, OfShapesMatchesDifferences) {
  const Device& device = test::device();
  SIMULI_NEEDS_DOUBLE(device);
  test::Shot shot = test::shot_of(test::kCameraStill, 16, 16);
  shot.camera.fx = shot.camera.fy = 4000.0;
  const test::SetRecipe recipe{.count = 12,
                               .low = {5, -1.5, -1.5},
                               .high = {12, 1.5, 1.5},
                               .scale_min = 0.7,
                               .scale_max = 2.0,
                               .opacity_min = 0.2,
                               .opacity_max = 0.8,
                               .sh_spread = 0.1};
  GaussianSet set = test::set_for(test::kCameraStill, recipe, 3);
  set.sh(0).array() += 1.5F;
  const auto problem_of = [&](Order order) {
    return Problem(device, shot, set, options_with(order, 8, Precision::kDouble));
  };
  Problem problem = problem_of(Order::kWindow);
  const std::vector<double> gradient = problem.gradient();
  GradientCheck check;
  for (int particle = 0; particle < 12; ++particle) {
    for (int row = 0; row < kShRow + 3; ++row) {
      const std::size_t parameter = problem.at(row, particle);
      check.add(row, gradient[parameter], problem.quotient(parameter, kStep));
    }
  }
  for (int group = 0; group < GradientCheck::kGroups - 1; ++group) {
    EXPECT_LE(check.worst(group), kGradientTolerance)
        << GradientCheck::kGroupNames[static_cast<std::size_t>(group)];
    EXPECT_TRUE(check.moves(group));
  }
  Problem by_range = problem_of(Order::kRange);
  EXPECT_GT(apart(all_of(by_range, 0, 12), all_of(problem, 0, 12)), 0.01) << "the orders do not differ";
}

TEST(GradientInOwnOrder, IsThatByRangeWhereTheOrdersAgree) {
  const Device& device = test::device();
  // Small round particles, each a metre behind the last: all orders agree.
  const GaussianSet set = [] {
    test::SetRecipe recipe{.count = 40, .scale_min = 0.04, .scale_max = 0.05, .opacity_max = 0.9};
    GaussianSet out = test::set_for(test::kCameraStill, recipe, 9);
    test::Random random(4);
    for (Eigen::Index i = 0; i < out.size(); ++i) {
      const auto range = static_cast<float>(4 + i);
      out.mean().row(i) << range, 0.005F * range * static_cast<float>(random.normal()),
          0.005F * range * static_cast<float>(random.normal());
    }
    return out;
  }();
  test::Shot shot = test::shot_of(test::kCameraStill, 48, 32);
  shot.camera.fx = shot.camera.fy = 1200.0;
  Problem by_range(device, shot, set, options_with(Order::kRange, 8, Precision::kFloat));
  for (const Order order : {Order::kWindow, Order::kPerRay}) {
    Problem by_ray(device, shot, set, options_with(order, 8, Precision::kFloat));
    EXPECT_EQ(by_ray.outputs_at(by_ray.base()), by_range.outputs_at(by_range.base()));
    EXPECT_EQ(all_of(by_ray, 0, 40), all_of(by_range, 0, 40));
  }
}

TEST(GradientInOwnOrder, IsTheSameAFewTilesAtATime) {
  const Device& device = test::device();
  const test::Shot shot = shot_for(test::kCameraStill);
  for (const Order order : {Order::kWindow, Order::kPerRay}) {
    const RenderOptions options = options_with(order, 4, Precision::kFloat);
    Renderer renderer(device, options);
    const SensorRays rays = shot.on(device, options);
    const ParticleBuffers particles(device, crowd(test::kCameraStill), options);
    Pass pass = renderer.render(particles, rays, shot.view);
    test::Random random(11);
    std::vector<double> weights(std::size_t{5} * rays.grid().rays);
    for (double& w : weights) w = random.normal();
    pass.set_output_gradients(weights);
    RealBuffer grads(device, "gradients", Precision::kFloat);
    pass.backward(particles, grads);
    const std::vector<double> at_once = pass.gradients().grads.download_double();
    // No list has a single pixel: each tile separately. Then several tiles together.
    for (const std::size_t places : {std::size_t{1}, std::size_t{150}}) {
      pass.backward(particles, grads, {.replayed = places});
      EXPECT_EQ(pass.gradients().grads.download_double(), at_once);
      EXPECT_LT(pass.gradients().replayed.count(), 512 * pass.buffers().binned.pairs);
    }
  }
}

}  // namespace render_window_bwd_test
}  // namespace simuli

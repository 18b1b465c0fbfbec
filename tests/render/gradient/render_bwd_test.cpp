// Tests gradients of the complete chain, by the double build of the kernels, against central differences of
// its forward pass.
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "tests/cl/support.hpp"
#include "tests/render/gradient/gradient_check.hpp"
#include "tests/render/gradient/gradient_problem.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

using test::GradientCheck;
using test::SceneCase;
using test::smooth_options;
using Problem = test::GradientProblem;

using test::kFloatGradientTolerance;
using test::kGradientTolerance;
constexpr double kStep = test::kQuotientStep;

/// Returns particles around the sensor or ahead of the camera, with opacities away from the clamp of alpha
/// and clamped features away from 0.
GaussianSet well_placed_set(const SceneCase& scene, int count, bool compensated = false) {
  const bool camera = scene.kind == SetKind::kCamera;
  test::SetRecipe recipe;
  recipe.count = count;
  recipe.low = camera ? Eigen::Vector3d(4, -2, -1.5) : Eigen::Vector3d(-7, -7, -2.5);
  recipe.high = camera ? Eigen::Vector3d(9, 2, 1.5) : Eigen::Vector3d(7, 7, 1.0);
  recipe.scale_min = camera ? 0.15 : 0.4;
  recipe.scale_max = camera ? 0.6 : 1.0;
  // Filtered particles must not reach the sensor: rays would start inside, and that cut is not smooth.
  if (!camera && compensated) recipe.scale_min = 0.1, recipe.scale_max = 0.3;
  recipe.opacity_min = 0.2;
  recipe.opacity_max = 0.9;
  recipe.sh_spread = 0.1;
  GaussianSet set = test::set_for(scene, recipe, 5);
  set.sh(0).array() += 1.5F;
  for (Eigen::Index i = 0; i < set.size(); ++i) {  // so far that a LiDAR is not inside
    const float flat = set.mean().row(i).head<2>().norm();
    if (!camera && flat < 4.0F) set.mean().row(i).head<2>() *= 4.0F / flat;
  }
  return set;
}

/// A scene with or without opacity compensation.
struct GradientCase {
  SceneCase scene;
  bool compensated = false;
};

class Gradient : public testing::TestWithParam<GradientCase> {
 protected:
  [[nodiscard]] static test::Shot shot() {
    const SceneCase& scene = GetParam().scene;
    test::Shot out =
        scene.kind == SetKind::kCamera ? test::shot_of(scene, 24, 20) : test::shot_of(scene, 60, 12);
    if (GetParam().compensated) {  // as wide at 6 m as the particles
      out.lidar.beam_divergence = 0.05;
      out.lidar.divergence_variance = 1.0;
    }
    return out;
  }
  [[nodiscard]] static RenderOptions options(Precision precision) {
    RenderOptions out = smooth_options(precision);
    out.camera_compensation = out.lidar_compensation = GetParam().compensated;
    // With beams this wide the unscented box cuts particles off at an alpha of 1e-6.
    if (GetParam().compensated) out.extent = Extent::kExact;
    return out;
  }
};

TEST_P(Gradient, MatchesDifferencesAndWrongOnesAreRejected) {
  const SceneCase& scene = GetParam().scene;
  const Device& device = test::device();
  SIMULI_NEEDS_DOUBLE(device);
  const GaussianSet set = well_placed_set(scene, 16, GetParam().compensated);
  Problem problem(device, shot(), set, options(Precision::kDouble));
  const std::vector<double> gradient = problem.gradient();

  GradientCheck check;
  const std::vector<int> moved =
      scene.sh_degree > 1 ? std::vector<int>{1, 6, 15} : std::vector<int>{0, 3, 7, 10, 15};
  for (const int particle : moved) {
    for (int row = 0; row < param_rows(scene.sh_degree); ++row) {
      const std::size_t parameter = problem.at(row, particle);
      check.add(row, gradient[parameter], problem.quotient(parameter, kStep));
    }
  }
  for (int group = 0; group < GradientCheck::kGroups; ++group) {
    EXPECT_LE(check.worst(group), kGradientTolerance)
        << GradientCheck::kGroupNames[static_cast<std::size_t>(group)];
    EXPECT_TRUE(check.moves(group)) << GradientCheck::kGroupNames[static_cast<std::size_t>(group)];
    // An error of one percent is four orders above the tolerance: the check detects it in each group.
    EXPECT_FALSE(check.scaled(group, 1.01).passes(kGradientTolerance));
    EXPECT_FALSE(check.scaled(group, -1.0).passes(kGradientTolerance));
  }
  EXPECT_TRUE(check.passes(kGradientTolerance));

  // The norm of a quaternion has no effect: the gradient is perpendicular to the quaternion.
  for (int particle = 0; particle < static_cast<int>(set.size()); ++particle) {
    double along = 0.0, size = 0.0;
    for (int k = 0; k < 4; ++k) {
      const std::size_t parameter = problem.at(kRotationRow + k, particle);
      along += gradient[parameter] * problem.base()[parameter];
      size += std::abs(gradient[parameter] * problem.base()[parameter]);
    }
    EXPECT_LE(std::abs(along), 1e-12 * size + 1e-300) << "particle " << particle;
  }
}

TEST_P(Gradient, FloatBuildAgreesWithTheDoubleBuild) {
  const SceneCase& scene = GetParam().scene;
  const Device& device = test::device();
  SIMULI_NEEDS_DOUBLE(device);
  const GaussianSet set = well_placed_set(scene, 16, GetParam().compensated);
  Problem in_double(device, shot(), set, options(Precision::kDouble));
  Problem in_float(device, shot(), set, options(Precision::kFloat));
  const std::vector<double> expected = in_double.gradient();
  const std::vector<double> found = in_float.gradient();
  ASSERT_EQ(found.size(), expected.size());
  std::vector<double> error2(GradientCheck::kGroups), size2(GradientCheck::kGroups);
  for (int row = 0; row < param_rows(scene.sh_degree); ++row) {
    const auto group = static_cast<std::size_t>(GradientCheck::group_of(row));
    for (int particle = 0; particle < static_cast<int>(set.size()); ++particle) {
      const std::size_t i = in_double.at(row, particle);
      error2[group] += (found[i] - expected[i]) * (found[i] - expected[i]);
      size2[group] += expected[i] * expected[i];
    }
  }
  for (std::size_t group = 0; group < error2.size(); ++group) {
    EXPECT_GT(size2[group], 0.0);
    EXPECT_LE(std::sqrt(error2[group] / size2[group]), kFloatGradientTolerance)
        << GradientCheck::kGroupNames[group];
  }
}

INSTANTIATE_TEST_SUITE_P(All,
                         Gradient,
                         testing::Values(GradientCase{test::kCameraSh3},
                                         GradientCase{test::kCameraRolling},
                                         GradientCase{test::kLidarMoving},
                                         GradientCase{test::kCameraRolling, true},
                                         GradientCase{test::kLidarMoving, true}),
                         [](const auto& pair) {
                           return std::string(pair.param.scene.name) +
                                  (pair.param.compensated ? "_compensated" : "");
                         });

/// A camera of 16 x 16 pixels with a field of view of +-2 mrad about +x: its picture is nearly constant.
test::Shot narrow_shot() {
  test::Shot shot = test::shot_of(test::kCameraSh3, 16, 16);
  shot.camera.fx = shot.camera.fy = 4000.0;
  return shot;
}

/// Returns degree-3 particles (a variant compiled for other tests) with zero higher bands.
GaussianSet plain_set(const std::vector<test::SingleParticle>& particles) {
  const GaussianSet flat = test::set_of(SetKind::kCamera, particles);
  GaussianSet set(SetKind::kCamera, 3, flat.size());
  set.params.leftCols(flat.params.cols()) = flat.params;
  return set;
}

TEST(GradientAtTheClamp, OpacityIsStillAndDistanceFlows) {
  const Device& device = test::device();
  SIMULI_NEEDS_DOUBLE(device);
  const Eigen::Quaterniond tilted(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
  // sigma = 0.9999 remains above the clamp of 0.999 up to 0.042 standard deviations: 4 cm, twice the picture.
  const GaussianSet set =
      plain_set({{.mean = {10, 0, 0}, .scale = {1.0, 2.0, 3.0}, .rotation = tilted, .opacity = 0.9999},
                 {.mean = {14, 0.01, 0.02}, .scale = {1.5, 1.0, 2.0}, .rotation = tilted, .opacity = 0.5}});
  Problem problem(device, narrow_shot(), set, smooth_options(Precision::kDouble));
  const std::vector<double> out = problem.outputs_at(problem.base());
  const std::size_t slots = problem.slots();
  // Behind the clamp 0.001 remains; the second particle absorbs about half of it.
  for (std::size_t i = 0; i < slots; ++i) ASSERT_NEAR(out[3 * slots + i], 0.0005, 2e-5);

  const std::vector<double> gradient = problem.gradient();
  EXPECT_EQ(gradient[problem.at(kOpacityRow, 0)], 0.0);
  EXPECT_NE(gradient[problem.at(kOpacityRow, 1)], 0.0);
  GradientCheck check;
  for (int particle = 0; particle < 2; ++particle) {
    for (int row = 0; row < kShRow + 3; ++row) {
      const std::size_t parameter = problem.at(row, particle);
      check.add(row, gradient[parameter], problem.quotient(parameter, kStep));
    }
  }
  for (int group = 0; group < GradientCheck::kGroups; ++group) {
    EXPECT_LE(check.worst(group), kGradientTolerance)
        << GradientCheck::kGroupNames[static_cast<std::size_t>(group)];
  }
  double moves_mean = 0.0;
  for (int row = 0; row < 3; ++row) moves_mean += std::abs(gradient[problem.at(row, 0)]);
  EXPECT_GT(moves_mean, 1e-3);
}

TEST(GradientAtTheCut, RaysThatEndAndRaysThatGoOnBothMatch) {
  const Device& device = test::device();
  SIMULI_NEEDS_DOUBLE(device);
  // Four layers leave 1e-4 at the centre, the cut; off the centre slightly more. Only the fifth layer is red.
  std::vector<test::SingleParticle> layers;
  for (int k = 0; k < 5; ++k) {
    layers.push_back({.mean = {10.0 + k, 0.001 * k, -0.0005 * k},
                      .scale = {0.3, 0.22, 0.18},
                      .opacity = k < 4 ? 0.9015 : 0.6,
                      .feature = {k < 4 ? 0.25 : 1.0, 0.5, 0.75}});
  }
  GaussianSet set = plain_set(layers);
  for (int k = 0; k < 4; ++k) set.sh(0)(k, 0) = -100.0F;  // clamped to 0 from far below
  test::Shot shot = narrow_shot();
  shot.view.background = {0.0F, 0.0F, 0.0F};
  RenderOptions options = smooth_options(Precision::kDouble);
  options.transmittance_cut = 1e-4;
  Problem problem(device, shot, set, options);
  const std::vector<double> out = problem.outputs_at(problem.base());
  const std::size_t slots = problem.slots();
  std::size_t ended = 0;
  for (std::size_t i = 0; i < slots; ++i) {
    const bool stopped = out[i] == 0.0;
    ended += stopped ? 1U : 0U;
    if (stopped) {
      // T of the fourth layer, below the cut and hence final; not so close that a step changes the decision.
      ASSERT_LT(out[3 * slots + i], 1e-4 * (1.0 - 1e-4));
    } else {
      ASSERT_GT(out[3 * slots + i] + out[i], 1e-4 * (1.0 + 1e-4));  // red is 1: T + red is T before it
    }
  }
  EXPECT_GT(ended, slots / 20);
  EXPECT_LT(ended, slots - slots / 20);

  const std::vector<double> gradient = problem.gradient();
  GradientCheck check;
  for (int particle = 0; particle < 5; ++particle) {
    for (int row = 0; row < kShRow + 3; ++row) {
      const std::size_t parameter = problem.at(row, particle);
      // Steps that change T by less than its distance from the cut: 1e-4 of it.
      const double step = row < 3 ? 2e-6 : 1e-5;
      check.add(row, gradient[parameter], problem.quotient(parameter, step));
    }
  }
  for (int group = 0; group < GradientCheck::kGroups; ++group) {
    EXPECT_LE(check.worst(group), kGradientTolerance)
        << GradientCheck::kGroupNames[static_cast<std::size_t>(group)];
  }
}

}  // namespace
}  // namespace simuli

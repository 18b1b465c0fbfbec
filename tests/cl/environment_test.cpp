// Tests the environment texture: forward against a sequential loop in double, gradients against difference
// quotients.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <optional>
#include <span>
#include <vector>

#include "host/core/base/angles.hpp"
#include "tests/cl/support.hpp"
#include "tests/render/gradient/gradient_check.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace environment_test {

constexpr double kGradientTolerance = 1e-6;
// Directions of 24 bits give positions of 1e-6 texels here, and texels differ by about 1.
constexpr double kFloatTolerance = 2e-5;
constexpr double kDoubleTolerance = 1e-11;

/// A camera with a field of view over all directions: the seam behind it, both poles. Few particles, so that
/// most rays reach the texture.
struct Panorama {
  explicit Panorama(int width = 48) {
    shot = test::shot_of(test::kCameraStill, width, width / 2);
    shot.camera.lens = Lens(LensKind::kEquirectangular, {});
    shot.camera.fx = shot.camera.fy = width / (2.0 * kPi);
    shot.camera.cx = 0.5 * width;
    shot.camera.cy = 0.25 * width;
    test::SetRecipe recipe;
    recipe.count = 40;
    recipe.scale_min = 0.2;
    recipe.scale_max = 0.8;
    set = test::set_for(test::kCameraStill, recipe, 3);
    set.sh(0).array() += 1.5F;  // clear of the clamp at 0
    for (Eigen::Index i = 0; i < set.size(); ++i) {
      // Around the camera at distinct ranges: quotient steps do not change the order.
      set.mean().row(i) *= (3.0F + 0.1F * static_cast<float>(i)) / set.mean().row(i).norm();
    }
    options.alpha_cut = 1e-12;        // no contribution appears or disappears by a quotient step,
    options.extent = Extent::kExact;  // and no box cuts contributions off
    options.transmittance_cut = 0.0;
  }
  test::Shot shot;
  GaussianSet set;
  RenderOptions options = paper_options();
};

EnvironmentMap random_map(int width, int height) {
  test::Random random(31);
  EnvironmentMap map{width, height, {}};
  for (int i = 0; i < 3 * width * height; ++i) map.texels.push_back(static_cast<float>(random.uniform(0, 1)));
  return map;
}

/// Returns the texture in a direction: azimuth and elevation, then four texels.
double lookup(const EnvironmentMap& map, double dx, double dy, double dz, int channel) {
  const double x = (0.5 - std::atan2(dy, dx) / (2.0 * kPi)) * map.width - 0.5;
  const double y = std::clamp((0.5 - std::atan2(dz, std::hypot(dx, dy)) / kPi) * map.height - 0.5,
                              0.0,
                              static_cast<double>(map.height - 1));
  const int x0 = static_cast<int>(std::floor(x));
  const int y0 = std::min(static_cast<int>(y), map.height - 2);
  double sum = 0.0;
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 2; ++i) {
      const int column = (x0 + i + map.width) % map.width;
      const double weight = (i == 1 ? x - x0 : 1.0 - (x - x0)) * (j == 1 ? y - y0 : 1.0 - (y - y0));
      const int texel = (y0 + j) * map.width + column;
      sum += weight * static_cast<double>(map.texels[static_cast<std::size_t>(3 * texel + channel)]);
    }
  }
  return sum;
}

/// Returns squared differences of neighbours, weighted by their share of the sphere.
double variation(const EnvironmentMap& map, const std::vector<double>& texture) {
  double sum = 0.0;
  const auto at = [&](int x, int y, int c) {
    return texture[static_cast<std::size_t>(4 * (y * map.width + (x + map.width) % map.width) + c)];
  };
  for (int y = 0; y < map.height; ++y) {
    const double elevation = kPi * (0.5 - (y + 0.5) / map.height);
    const double edge = kPi * (0.5 - (y + 1.0) / map.height);
    for (int x = 0; x < map.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        sum += std::pow(at(x, y, c) - at(x + 1, y, c), 2) / std::cos(elevation);
        if (y + 1 < map.height) sum += std::pow(at(x, y, c) - at(x, y + 1, c), 2) * std::cos(edge);
      }
    }
  }
  return sum;
}

class Environment : public testing::TestWithParam<Precision> {
 protected:
  Device device_ = test::device();
};

TEST_P(Environment, FillsWhatTheForegroundLeaves) {
  if (GetParam() == Precision::kDouble) SIMULI_NEEDS_DOUBLE(device_);
  for (const LaneShape& shape : {test::kDefaultShape, test::kGpuShape}) {
    Panorama scene;
    scene.options.precision = GetParam();
    scene.options.shape = shape;
    Renderer renderer(device_, scene.options);
    const SensorRays rays = scene.shot.on(device_, scene.options);
    const ParticleBuffers particles(device_, scene.set, GetParam());
    View black = scene.shot.view;
    black.background = {0.0F, 0.0F, 0.0F};
    Pass pass = renderer.render(particles, rays, black);
    const std::vector<double> before = test::outputs(pass);
    const EnvironmentMap map = random_map(9, 5);  // odd: no texel falls on the seam by symmetry
    const EnvironmentBuffers environment(device_, map, GetParam());
    pass = renderer.render(particles, rays, scene.shot.view, &environment);
    const std::vector<double> found = test::outputs(pass);
    const std::vector<double> ray = pass.buffers().rays.world_ray.download_double();
    const std::size_t s = rays.grid().frame.slots;
    const double tolerance = GetParam() == Precision::kDouble ? kDoubleTolerance : kFloatTolerance;
    double seen = 0.0;
    for (std::size_t i = 0; i < s; ++i) {
      if (rays.grid().ray_of_slot[i] < 0) continue;
      const double left = before[3 * s + i];
      seen = std::max(seen, left);
      for (std::size_t c = 0; c < 3; ++c) {
        const double colour = lookup(map, ray[i], ray[s + i], ray[2 * s + i], static_cast<int>(c));
        ASSERT_NEAR(found[c * s + i], before[c * s + i] + left * colour, tolerance) << i;
      }
      ASSERT_EQ(found[3 * s + i], left);
    }
    EXPECT_GT(seen, 0.9);
  }
}

/// Difference quotients are inaccurate in float.
class EnvironmentInDouble : public Environment {};

TEST_P(EnvironmentInDouble, GradientsMatchQuotientsAndWrongOnesDoNot) {
  SIMULI_NEEDS_DOUBLE(device_);
  Panorama scene(24);
  scene.options.precision = GetParam();
  Renderer renderer(device_, scene.options);
  const SensorRays rays = scene.shot.on(device_, scene.options);
  ParticleBuffers particles(device_, scene.set, GetParam());
  const EnvironmentMap map = random_map(9, 5);
  EnvironmentBuffers environment(device_, map, GetParam());
  std::vector<double> weights(std::size_t{5} * rays.grid().frame.slots);
  test::Random random(7);
  for (double& w : weights) w = random.normal();
  constexpr double kVariation = 0.7;
  std::vector<double> texture = environment.texture.download_double();
  std::vector<double> params = particles.params.download_double();
  std::optional<Pass> last;
  const auto loss = [&] {
    environment.texture.assign(std::span<const double>(texture));
    particles.params.assign(std::span<const double>(params));
    last = renderer.render(particles, rays, scene.shot.view, &environment);
    const std::vector<double> out = test::outputs(*last);
    double sum = kVariation * variation(map, texture);
    for (std::size_t i = 0; i < out.size(); ++i) {
      if (rays.grid().ray_of_slot[i % rays.grid().frame.slots] >= 0) sum += weights[i] * out[i];
    }
    return sum;
  };
  const auto moved = [&](std::vector<double>& values) {
    return [&values, &loss](std::size_t i, double by) {
      const double before = values[i];
      values[i] = before + by;
      const double result = loss();
      values[i] = before;
      return result;
    };
  };
  (void)loss();
  Pass pass = *last;
  pass.set_output_gradients(test::by_ray(pass.rays(), weights));
  RealBuffer texture_grads(device_, "texture gradients", GetParam());
  RealBuffer grads(device_, "gradients", GetParam());
  pass.environment_backward(environment, kVariation, texture_grads);
  pass.backward(particles, grads);
  const std::vector<double> texture_gradient = texture_grads.download_double();
  const std::vector<double> gradient = grads.download_double();

  std::vector<std::size_t> colours;
  for (std::size_t i = 0; i < texture.size(); ++i) {
    if (i % 4 < 3) {
      colours.push_back(i);
    } else {
      EXPECT_EQ(texture_gradient[i], 0.0);
    }
  }
  const test::Quotients of_texture = test::compare_quotients(texture_gradient, colours, moved(texture));
  EXPECT_LE(of_texture.error, kGradientTolerance);
  EXPECT_GT(of_texture.error_if_scaled, kGradientTolerance);
  // Occlusion of the texture by a particle: its opacity and position.
  for (const int row : {kMeanRow + 0, kMeanRow + 2, kOpacityRow + 0}) {
    std::vector<std::size_t> entries;
    for (std::size_t p = 0; p < 12; ++p) {
      entries.push_back(static_cast<std::size_t>(row) * particles.stride + p);
    }
    const test::Quotients of_particles = test::compare_quotients(gradient, entries, moved(params));
    EXPECT_LE(of_particles.error, kGradientTolerance) << row;
    EXPECT_GT(of_particles.error_if_scaled, kGradientTolerance) << row;
  }
}

TEST_P(Environment, GradientRepeatsBitForBitAndRaysAtTheCutHaveNone) {
  if (GetParam() == Precision::kDouble) SIMULI_NEEDS_DOUBLE(device_);
  Panorama scene;
  scene.options.precision = GetParam();
  scene.options.transmittance_cut = 0.5;
  Renderer renderer(device_, scene.options);
  const SensorRays rays = scene.shot.on(device_, scene.options);
  const ParticleBuffers particles(device_, scene.set, GetParam());
  const EnvironmentBuffers environment(device_, random_map(9, 5), GetParam());
  Pass pass = renderer.render(particles, rays, scene.shot.view, &environment);
  const std::vector<double> out = test::outputs(pass);
  const std::size_t s = rays.grid().frame.slots;
  std::vector<double> weights(5 * s, 0.0);
  std::size_t shut = 0;
  for (std::size_t i = 0; i < s; ++i) {
    const bool is_shut = rays.grid().ray_of_slot[i] >= 0 && out[3 * s + i] < 0.5;
    shut += is_shut ? 1U : 0U;
    if (is_shut) weights[i] = 1.0;  // only for rays without a visible part of the texture
  }
  EXPECT_GT(shut, 20U);
  RealBuffer grads(device_, "texture gradients", GetParam());
  pass.set_output_gradients(test::by_ray(pass.rays(), weights));
  pass.environment_backward(environment, 0.0, grads);
  for (const double g : grads.download_double()) ASSERT_EQ(g, 0.0);
  std::fill(weights.begin(), weights.end(), 1.0);
  pass.set_output_gradients(test::by_ray(pass.rays(), weights));
  pass.environment_backward(environment, 0.3, grads);
  const std::vector<double> first = grads.download_double();
  pass.environment_backward(environment, 0.3, grads);
  EXPECT_EQ(first, grads.download_double());
  EXPECT_GT(*std::max_element(first.begin(), first.end()), 0.0);
}

INSTANTIATE_TEST_SUITE_P(All, EnvironmentInDouble, testing::Values(Precision::kDouble));
INSTANTIATE_TEST_SUITE_P(All,
                         Environment,
                         testing::Values(Precision::kFloat, Precision::kDouble),
                         [](const auto& pair) {
                           return pair.param == Precision::kFloat ? "in_float" : "in_double";
                         });

}  // namespace environment_test
}  // namespace simuli

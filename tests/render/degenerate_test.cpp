// Tests degenerate input: no particles, one, unusable particles, sensors of one ray. All outputs are finite,
// and equal to the background without particles.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <string>
#include <vector>

#include "tests/cl/support.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

using test::SceneCase;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kLargest = std::numeric_limits<float>::max();
// Float logits: T is 1 and features equal the background up to rounding.
constexpr float kRounding = 1e-5F;

/// One renderer for all frames: its buffers keep values of larger frames.
class Degenerate : public testing::TestWithParam<SceneCase> {
 protected:
  [[nodiscard]] bool camera() const { return GetParam().kind == SetKind::kCamera; }
  [[nodiscard]] test::Shot shot(int width, int height) const {
    test::Shot one = test::shot_of(GetParam(), width, height);
    one.view.background = {0.25F, -1.0F, 1.5F};
    one.camera.fx = one.camera.fy = 24.0;  // for all sizes, all pixels have a ray
    return one;
  }
  [[nodiscard]] test::Shot usual_shot() const { return camera() ? shot(40, 36) : shot(80, 18); }
  /// Returns visible opaque particles, some of which tests make unusable.
  [[nodiscard]] GaussianSet plain(Eigen::Index count) const {
    GaussianSet set(GetParam().kind, GetParam().sh_degree, count);
    set.mean().col(0).setConstant(6.0F);
    set.log_scale().setConstant(-1.0F);
    set.rotation().col(0).setOnes();
    set.opacity_logit().setConstant(2.0F);
    set.sh(0).setConstant(0.3F);
    return set;
  }
  /// Renders, computes gradients and checks that all are finite.
  RayResults render(const GaussianSet& set, const test::Shot& one) {
    const SensorRays rays = one.on(device_, options_);
    const ParticleBuffers particles(device_, set, Precision::kFloat);
    Pass pass = renderer_.render(particles, rays, one.view);
    RayResults results = pass.results();
    for (const auto& values : {results.feature[0], results.feature[1], results.feature[2]})
      expect_finite(values);
    expect_finite(results.transmittance);
    expect_finite(results.distance);
    expect_finite(results.median);
    pass.set_output_gradients(std::vector<double>(5 * rays.grid().rays, 1.0));
    RealBuffer grads(device_, "gradients", Precision::kFloat, particles.params.count());
    grads.fill(static_cast<double>(kNan));
    pass.backward(particles, grads);
    // Culled particles have gradients of 0.
    const std::vector<std::uint32_t> keys = pass.buffers().projected.keys.download();
    const std::vector<float> all = grads.download_float();
    gradients_.clear();
    for (std::size_t i = 0; i < all.size(); ++i) {
      const std::size_t particle = i % particles.stride;
      if (particle >= particles.count) continue;
      if (keys[particle] != 0xffffffffU) {
        gradients_.push_back(all[i]);
      } else {
        EXPECT_EQ(all[i], 0.0F) << "of particle " << particle;
      }
    }
    visible_ = pass.buffers().binned.visible;
    pairs_ = pass.buffers().binned.pairs;
    expect_finite(gradients_);
    return results;
  }
  static void expect_finite(const std::vector<float>& values) {
    for (const float v : values) ASSERT_TRUE(std::isfinite(v));
  }
  void expect_background(const RayResults& results, const test::Shot& one) {
    for (std::size_t i = 0; i < results.rays; ++i) {
      for (std::size_t k = 0; k < 3; ++k) ASSERT_EQ(results.feature[k][i], one.view.background[k]) << i;
      ASSERT_EQ(results.transmittance[i], 1.0F) << i;
      ASSERT_EQ(results.distance[i], 0.0F) << i;
      if (!results.median.empty()) {
        ASSERT_EQ(results.median[i], 0.0F) << i;
      }
    }
    EXPECT_TRUE(gradients_.empty());
    EXPECT_EQ(visible_, 0U);
    EXPECT_EQ(pairs_, 0U);
  }
  /// Fills all buffers of the renderer.
  void leave_traces() {
    const test::SetRecipe recipe{.count = 300, .low = {-8, -8, -3}, .high = {8, 8, 3}};
    const GaussianSet set = test::set_for(GetParam(), recipe, 3);
    const RayResults results = render(set, usual_shot());
    EXPECT_LT(*std::min_element(results.transmittance.begin(), results.transmittance.end()), 0.5F);
  }

  Device device_ = test::device();
  RenderOptions options_ = paper_options();
  Renderer renderer_{device_, options_};
  std::vector<float> gradients_;  // of particles that the last render did not cull
  std::uint32_t visible_ = 0, pairs_ = 0;
};

TEST_P(Degenerate, NothingIsTheBackground) {
  leave_traces();
  const test::Shot usual = usual_shot();
  expect_background(render(plain(0), usual), usual);
  leave_traces();
  GaussianSet all_culled = plain(300);
  if (camera()) {
    all_culled.mean().col(0).setConstant(-6.0F);  // behind the camera
  } else {
    all_culled.mean().col(0).setConstant(500.0F);  // out of range
  }
  expect_background(render(all_culled, usual), usual);
  GaussianSet transparent = plain(33);
  transparent.opacity_logit().setConstant(-1e30F);
  expect_background(render(transparent, usual), usual);
  // One visible particle.
  const RayResults one = render(plain(1), usual);
  EXPECT_LT(*std::min_element(one.transmittance.begin(), one.transmittance.end()), 0.3F);
  EXPECT_EQ(visible_, 1U);
}

TEST_P(Degenerate, ParticlesThatAreNoNumberAreCulled) {
  leave_traces();
  const test::Shot usual = usual_shot();
  for (int row = 0; row < param_rows(GetParam().sh_degree); ++row) {
    for (const float value : {kNan, kInf, -kInf}) {
      GaussianSet set = plain(1);
      set.params(0, row) = value;
      SCOPED_TRACE("row " + std::to_string(row) + " is " + std::to_string(value));
      expect_background(render(set, usual), usual);
      if (HasFatalFailure()) return;
    }
  }
  GaussianSet zero = plain(1);
  zero.rotation().setZero();
  expect_background(render(zero, usual), usual);
  // Other particles in the same vector of lanes are unaffected.
  const RayResults alone = render(plain(1), usual);
  GaussianSet mixed = plain(11);
  for (Eigen::Index i = 1; i < 11; ++i) mixed.params(i, (i * 7) % mixed.params.cols()) = kNan;
  const RayResults beside = render(mixed, usual);
  EXPECT_EQ(visible_, 1U);
  EXPECT_EQ(beside.transmittance, alone.transmittance);
  EXPECT_EQ(beside.feature[0], alone.feature[0]);
}

TEST_P(Degenerate, ExtremeValuesStayFinite) {
  const test::Shot usual = usual_shot();
  for (int row = 0; row < param_rows(GetParam().sh_degree); ++row) {
    for (const float value : {1e-20F,
                              -1e-20F,
                              1e-40F,
                              46.0F,
                              -46.0F,
                              90.0F,
                              -90.0F,
                              1e20F,
                              -1e20F,
                              1e30F,
                              -1e30F,
                              kLargest,
                              -kLargest}) {
      GaussianSet set = plain(2);
      set.params(0, row) = value;
      SCOPED_TRACE("row " + std::to_string(row) + " is " + std::to_string(value));
      static_cast<void>(render(set, usual));
      // A large value moves or hides its particle; the other particle is always visible.
      EXPECT_GE(visible_, 1U);
      if (HasFatalFailure()) return;
    }
  }
  GaussianSet opaque = plain(1);
  opaque.opacity_logit().setConstant(1e30F);
  opaque.log_scale().setConstant(2.0F);  // so wide that some ray is close to its centre
  const RayResults shut = render(opaque, usual);
  // alpha is clamped at 0.999.
  EXPECT_NEAR(*std::min_element(shut.transmittance.begin(), shut.transmittance.end()), 0.001F, kRounding);
  for (const float log_scale : {-46.0F, 46.0F}) {  // 1e-20 m and 1e20 m, all three axes
    GaussianSet set = plain(1);
    set.log_scale().setConstant(log_scale);
    static_cast<void>(render(set, usual));
  }
}

TEST_P(Degenerate, ParticlesAtAndAroundTheSensor) {
  const test::Shot usual = usual_shot();
  const Eigen::Vector3f centre =
      interpolate(usual.view.scene_from_sensor_start, usual.view.scene_from_sensor_end, 0.5)
          .translation.cast<float>();
  GaussianSet at_origin = plain(1);
  at_origin.mean().row(0) = centre.transpose();
  expect_background(render(at_origin, usual), usual);

  // A wide ball with its centre half a metre ahead: visible to the camera in all pixels; the LiDAR has a
  // minimum range of 1 m, beyond the ball's maximum along a ray.
  GaussianSet around = plain(1);
  around.mean().row(0) = (centre + Eigen::Vector3f(0.5F, 0.0F, 0.0F)).transpose();
  around.log_scale().setConstant(2.0F);
  const RayResults inside = render(around, usual);
  if (camera()) {
    for (const float t : inside.transmittance) ASSERT_LT(t, 0.2F);
  } else {
    for (const float t : inside.transmittance) ASSERT_EQ(t, 1.0F);
  }

  // Directly above and below a LiDAR the azimuth is undefined; a camera has these directions at the edge of
  // its view.
  for (const float z : {-3.0F, 3.0F}) {
    GaussianSet pole = plain(1);
    pole.mean().row(0) = (centre + Eigen::Vector3f(0.0F, 0.0F, z)).transpose();
    pole.log_scale().setConstant(0.0F);
    static_cast<void>(render(pole, usual));
  }
}

TEST_P(Degenerate, SensorsOfFewRays) {
  const test::SetRecipe recipe{.count = 200, .low = {-8, -8, -3}, .high = {8, 8, 3}};
  const GaussianSet set = test::set_for(GetParam(), recipe, 3);
  struct Size {
    int width, height;
  };
  for (const Size size : {Size{1, 1}, Size{1, 40}, Size{40, 1}, Size{17, 16}, Size{16, 17}, Size{33, 9}}) {
    SCOPED_TRACE(std::to_string(size.width) + " x " + std::to_string(size.height));
    leave_traces();
    const test::Shot small = shot(size.width, size.height);
    const RayResults results = render(set, small);
    ASSERT_EQ(results.rays, static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height));
    // The reference renders sensors this small completely: compares all rays.
    const auto expected =
        reference::render(reference::Particles(set), small.reference(), {}, {0.25, -1.0, 1.5});
    for (std::size_t i = 0; i < results.rays; ++i) {
      constexpr double kDecided = 1e-3;  // a decision within this margin may differ
      constexpr double kFloatTolerance = 3e-3;
      if (expected[i].margin < kDecided) continue;
      ASSERT_NEAR(static_cast<double>(results.transmittance[i]), expected[i].transmittance, kFloatTolerance);
    }
    expect_background(render(plain(0), small), small);
    if (HasFatalFailure()) return;
  }
}

INSTANTIATE_TEST_SUITE_P(All,
                         Degenerate,
                         testing::Values(test::kCameraStill, test::kLidarMoving),
                         [](const auto& pair) { return std::string(pair.param.name); });

}  // namespace
}  // namespace simuli

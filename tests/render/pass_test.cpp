// Tests the errors of a pass, each one line of Error{kUsage}, and the lifetime of its data.
#include <algorithm>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <string>
#include <utility>
#include <vector>

#include "tests/cl/support.hpp"
#include "tests/host/expect_error.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

constexpr Precision kFloat = Precision::kFloat;

/// A camera and a LiDAR with a set for each, and rays of both.
class Passes : public testing::Test {
 protected:
  [[nodiscard]] ParticleBuffers particles(const test::SceneCase& scene, Eigen::Index count = 40) const {
    return {device_, test::set_for(scene, {.count = count}, 3), kFloat};
  }
  Pass camera_pass(const EnvironmentBuffers* environment = nullptr) {
    return renderer_.render(camera_set_, camera_, picture_.view, environment);
  }
  Pass lidar_pass() { return renderer_.render(lidar_set_, lidar_, sweep_.view); }
  [[nodiscard]] static RayValues truth(const SensorRays& rays, std::size_t channels) {
    return {rays, std::vector<float>(channels * rays.grid().rays, 0.5F), channels};
  }
  template <class F>
  static void refused(const std::string& part, F&& f) {
    expect_error(ErrorKind::kUsage, part, f);
  }

  Device device_ = test::device();
  Renderer renderer_{device_, {}};
  test::Shot picture_ = test::shot_of(test::kCameraStill, 40, 30),
             sweep_ = test::shot_of(test::kLidarStill, 60, 12);
  SensorRays camera_ = picture_.on(device_, {}), lidar_ = sweep_.on(device_, {});
  ParticleBuffers camera_set_ = particles(test::kCameraStill), lidar_set_ = particles(test::kLidarStill);
  RealBuffer grads_{device_, "gradients", kFloat};
  ColorGridBuffers grids_{device_, ColorGrids::identity(2, 2, 2, {{"front", 0.0}}), kFloat};
  EnvironmentBuffers sky_{device_, EnvironmentMap{4, 3, std::vector<float>(36, 0.5F)}, kFloat};
};

TEST_F(Passes, ThatIsNotTheLastIsRefused) {
  Pass first = camera_pass();
  const RayValues values = truth(camera_, 3);
  (void)camera_pass();
  const std::string part = "pass 1 of a renderer that has gone on to 2";
  refused("results: found " + part, [&] { (void)first.results(); });
  refused("grade: found " + part, [&] { first.grade(grids_, 0); });
  refused("image_loss: found " + part, [&] { (void)first.image_loss(values, {1.0, 0.0, 0.0}); });
  refused("lidar_loss: found " + part, [&] { (void)first.lidar_loss(values, {}); });
  refused("set_output_gradients: found " + part, [&] { first.set_output_gradients({}); });
  refused("grade_backward: found " + part, [&] { first.grade_backward(grids_, 0, {}, grads_); });
  refused("environment_backward: found " + part, [&] { first.environment_backward(sky_, 0.0, grads_); });
  refused("backward: found " + part, [&] { first.backward(camera_set_, grads_); });
  refused("pose_gradients: found " + part, [&] { (void)first.pose_gradients(camera_set_); });
  refused("buffers: found " + part, [&] { (void)first.buffers(); });
  refused("gradients: found " + part, [&] { (void)first.gradients(); });
  refused("picture: found " + part, [&] { (void)first.picture(); });
  refused("ray_error: found " + part, [&] { (void)first.ray_error(); });
  refused("rays: found " + part, [&] { (void)first.rays(); });
  refused("frame: found " + part, [&] { (void)first.frame(); });
}

TEST_F(Passes, OutliveTheirRendererRaysAndParticles) {
  const std::vector<float> expected = camera_pass().results().transmittance;
  const auto temporary = [&] {
    return Renderer(device_, {})
        .render(particles(test::kCameraStill), picture_.on(device_, {}), picture_.view);
  };
  EXPECT_EQ(temporary().results().transmittance, expected);
  Renderer moved = std::move(renderer_);
  const Pass pass = moved.render(camera_set_, camera_, picture_.view);
  renderer_ = std::move(moved);
  EXPECT_EQ(pass.results().transmittance, expected);
}

TEST_F(Passes, AreNotOfThingsMadeWithOtherOptions) {
  RenderOptions wide, unculled;
  wide.camera_filter_px2 = 1.0;
  const std::string own = fmt::format("{}", kPixelVariance_px2);
  unculled.culling = Culling::kOff;
  refused("rays: render.camera_filter_px2: found 1, allowed " + own + " as the renderer's",
          [&] { (void)renderer_.render(camera_set_, picture_.on(device_, wide), picture_.view); });
  refused("rays: render.culling: found off, allowed auto as the renderer's",
          [&] { (void)renderer_.render(lidar_set_, sweep_.on(device_, unculled), sweep_.view); });
  refused("an environment behind a LiDAR",
          [&] { (void)renderer_.render(lidar_set_, lidar_, sweep_.view, &sky_); });
  GaussianSet riding = test::set_for(test::kCameraStill, {.count = 4}, 3);
  riding.actor = {0, 1, 2, 0};
  const ParticleBuffers of_actors(device_, riding, kFloat);
  refused("found a view of 0 actors, allowed the 2 that particles belong to",
          [&] { (void)renderer_.render(of_actors, camera_, picture_.view); });
  // Failed calls are no frames: the last frame is unchanged.
  const Pass pass = camera_pass();
  refused("rays: render.camera",
          [&] { (void)renderer_.render(camera_set_, picture_.on(device_, wide), picture_.view); });
  EXPECT_EQ(pass.results().rays, camera_.grid().rays);
  if (!test::has_double(device_)) return;
  RenderOptions precise;
  precise.precision = Precision::kDouble;
  refused("rays: render.precision: found double, allowed float as the renderer's",
          [&] { (void)renderer_.render(camera_set_, picture_.on(device_, precise), picture_.view); });
  const ParticleBuffers doubles(device_, riding, Precision::kDouble);
  refused("particles of the other precision",
          [&] { (void)renderer_.render(doubles, camera_, picture_.view); });
}

TEST_F(Passes, AskForTheirOwnRaysAndParticles) {
  Pass pass = camera_pass();
  refused("image_loss: found values of other rays", [&] {
    (void)pass.image_loss(truth(picture_.on(device_, {}), 3), {1.0, 0.0, 0.0});
  });
  refused("image_loss: found 2 channels, allowed 3", [&] {
    (void)pass.image_loss(truth(camera_, 2), {1.0, 0.0, 0.0});
  });
  refused("lidar_loss: found a camera's frame", [&] { (void)pass.lidar_loss(truth(camera_, 2), {}); });
  refused("found 7, allowed 5 for each of 1200 rays",
          [&] { pass.set_output_gradients(std::vector<double>(7, 1.0)); });
  refused("found 3, allowed 2 for each of 720 rays", [&] { RayValues(lidar_, {1.0F, 2.0F, 3.0F}, 2); });
  pass.set_output_gradients(std::vector<double>(5 * camera_.grid().rays, 1.0));
  const ParticleBuffers twin = particles(test::kCameraStill);
  refused("backward: found other particles", [&] { pass.backward(twin, grads_); });
  pass.backward(camera_set_, grads_);
  refused("pose_gradients: found other particles", [&] { (void)pass.pose_gradients(twin); });
  camera_set_.upload(test::set_for(test::kCameraStill, {.count = 50}, 3));
  refused("backward: found 50 particles, allowed 40", [&] { pass.backward(camera_set_, grads_); });

  pass = lidar_pass();
  refused("image_loss: found a LiDAR's frame", [&] { (void)pass.image_loss(truth(lidar_, 3), {}); });
  refused("grade: found a LiDAR's frame", [&] { pass.grade(grids_, 0); });
}

TEST_F(Passes, GoBackInOrder) {
  Pass pass = camera_pass(&sky_);
  RealBuffer other(device_, "other gradients", kFloat);
  refused("backward: found no gradient", [&] { pass.backward(camera_set_, grads_); });
  refused("environment_backward: found no gradient", [&] { pass.environment_backward(sky_, 0.0, other); });
  refused("grade_backward: found no gradient", [&] { pass.grade_backward(grids_, 0, {}, other); });
  refused("grade: found grid 1, allowed one of 1", [&] { pass.grade(grids_, 1); });
  const RayValues values = truth(camera_, 3);
  (void)pass.image_loss(values, {1.0, 0.0, 0.0});
  pass.grade(grids_, 0);
  refused("backward: found no gradient", [&] { pass.backward(camera_set_, grads_); });
  refused("grade: found a picture that has been graded", [&] { pass.grade(grids_, 0); });
  (void)pass.image_loss(values, {1.0, 0.0, 0.0});
  refused("backward: found the gradient of a graded picture", [&] { pass.backward(camera_set_, grads_); });
  pass.grade_backward(grids_, 0, {}, other);
  refused("grade_backward: found no gradient", [&] { pass.grade_backward(grids_, 0, {}, other); });
  const EnvironmentBuffers another(device_, EnvironmentMap{4, 3, std::vector<float>(36, 0.5F)}, kFloat);
  refused("environment_backward: found an environment that was not rendered",
          [&] { pass.environment_backward(another, 0.0, other); });
  pass.environment_backward(sky_, 0.0, other);
  refused("pose_gradients: found no gradients", [&] { (void)pass.pose_gradients(camera_set_); });
  refused("backward: found no ray errors", [&] { pass.backward(camera_set_, grads_, {.errors = true}); });
  pass.backward(camera_set_, grads_);
  EXPECT_TRUE(pass.pose_gradients(camera_set_).empty());
}

TEST_F(Passes, TakeGradientsInTheOrderOfRays) {
  // Only one ray's feature has a gradient: it equals the gradient of the ray's slot on the device.
  const Pass last = lidar_pass();
  const std::vector<float> distance = last.results().distance;
  const auto best =
      static_cast<std::size_t>(std::max_element(distance.begin(), distance.end()) - distance.begin());
  Pass pass = last;
  std::vector<double> gradients(5 * lidar_.grid().rays, 0.0);
  gradients[best] = 1.0;
  pass.set_output_gradients(gradients);
  const std::vector<double> slots = pass.gradients().grad_out.download_double();
  for (std::size_t slot = 0; slot < pass.frame().slots; ++slot) {
    const bool is_its = lidar_.grid().ray_of_slot[slot] == static_cast<std::int32_t>(best);
    ASSERT_EQ(slots[slot], is_its ? 1.0 : 0.0) << slot;
  }
}

}  // namespace
}  // namespace simuli

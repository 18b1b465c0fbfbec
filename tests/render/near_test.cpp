// Tests render.camera_near_m: nearer particles are invisible to a camera; all others are unchanged.
#include <gtest/gtest.h>

#include "tests/cl/support.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

const test::SingleParticle kNear{
    .mean = {0.6, 0.02, 0.01}, .scale = {0.05, 0.05, 0.05}, .opacity = 0.7, .feature = {0.9, 0.1, 0.4}};
const test::SingleParticle kFar{
    .mean = {6.0, 0.3, -0.2}, .scale = {0.8, 0.5, 0.6}, .opacity = 0.8, .feature = {0.2, 0.6, 0.3}};

class Near : public testing::TestWithParam<Order> {
 protected:
  [[nodiscard]] RayResults render(const std::vector<test::SingleParticle>& particles, double near_m) const {
    RenderOptions options;
    options.order = GetParam();
    options.camera_near_m = near_m;
    Renderer renderer(device_, options);
    const test::Shot shot = test::shot_of(test::kCameraStill, 40, 36);
    return renderer
        .render(ParticleBuffers(device_, test::set_of(SetKind::kCamera, particles), options),
                shot.on(device_, options),
                shot.view)
        .results();
  }

  Device device_ = test::device();
};

TEST_P(Near, OnlyWhatIsNearerIsLeftOut) {
  const RayResults both = render({kNear, kFar}, RenderOptions{}.camera_near_m);
  const RayResults far = render({kFar}, RenderOptions{}.camera_near_m);
  const RayResults cut = render({kNear, kFar}, 1.0);
  EXPECT_NE(both.transmittance, far.transmittance);
  EXPECT_EQ(cut.transmittance, far.transmittance);
  EXPECT_EQ(cut.distance, far.distance);
  EXPECT_EQ(render({kNear, kFar}, 0.3).transmittance, both.transmittance);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(cut.feature[k], far.feature[k]);
}

INSTANTIATE_TEST_SUITE_P(Orders, Near, testing::Values(Order::kRange, Order::kWindow, Order::kPerRay));

}  // namespace
}  // namespace simuli

// Tests the actor of the particle at which a ray's transmittance falls below one half.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "host/core/base/error.hpp"
#include "tests/render/scene/two_cars.hpp"
#include "tests/render/scene/wall_and_actor.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

using test::at_origin;
using test::still_camera;
using test::wall_and_actor;

TEST(FrameActors, AreThoseAtTheMedianDistanceInEveryOrder) {
  for (const Order order : {Order::kRange, Order::kWindow, Order::kPerRay}) {
    RenderOptions options;
    options.order = order;
    SceneOnDevice scene(test::device(), wall_and_actor(), options);
    const Sensor sensor = still_camera();
    const Frame frame = scene.render(sensor, at_origin(sensor), {.camera_median = true, .actors = true});
    const std::vector<std::uint32_t> actors = frame.owners();
    const std::vector<float>& median = frame.results().median;
    std::size_t own = 0;
    for (std::size_t i = 0; i < actors.size(); ++i) {
      const bool is_ahead = median[i] > 4.9F && median[i] < 5.2F;
      EXPECT_EQ(actors[i], is_ahead ? 2U : 0U) << i << ": " << median[i];
      own += is_ahead ? 1 : 0;
    }
    EXPECT_GT(own, 10U);
    EXPECT_LT(own, actors.size() / 2);
  }
}

TEST(FrameActors, LeaveTheFrameAsItIs) {
  SceneOnDevice scene(test::device(), test::two_cars());
  for (const Sensor& sensor : {test::camera(), test::lidar()}) {
    const Shot shot = test::shot_of(sensor, 0.1);
    FrameRequest request;
    const RayResults plain = scene.render(sensor, shot, request).results();
    request.actors = true;
    const Frame frame = scene.render(sensor, shot, request);
    frame.wait();
    EXPECT_TRUE(frame.is_ready());
    EXPECT_EQ(frame.results().feature[0], plain.feature[0]);
    EXPECT_EQ(frame.results().distance, plain.distance);
    EXPECT_EQ(frame.results().median, plain.median);
    const std::vector<std::uint32_t> actors = frame.owners();
    EXPECT_GT(std::count(actors.begin(), actors.end(), 1U), 3);
    // Half of the light is absorbed at an actor's particle: without the actor the median is elsewhere.
    Shot without = shot;
    without.edits = {{"near", ActorEdit::Remove{}}};
    request.camera_median = true;
    const Frame with = scene.render(sensor, shot, request), left = scene.render(sensor, without, request);
    const std::vector<std::uint32_t> others = left.owners();
    EXPECT_EQ(std::count(others.begin(), others.end(), 1U), 0);
    for (std::size_t i = 0; i < others.size(); ++i) {
      if (actors[i] != 1U) continue;
      EXPECT_NE(left.results().median[i], with.results().median[i]) << i;
    }
  }
}

// An upright actor of 1 m in a box of 2 m, with its particles of the road below and beside the box.
TEST(FrameActors, AreBodiesWithoutShadowAndRoad) {
  const struct {
    Eigen::Vector3d at_m;
    bool is_body;
  } cases[] = {{{0.0, 0.0, 0.0}, true},
               {{0.0, 1.05, 0.0}, true},     // labels are not exact
               {{0.0, 1.15, 0.0}, false},    // beside the box
               {{0.0, 0.0, 1.05}, true},     // on the roof
               {{0.0, 0.0, -0.9}, true},     // a tyre
               {{0.0, 0.0, -1.0}, false},    // the road below
               {{0.0, 0.0, -1.04}, false}};  // also if the label extends into the road
  for (const auto& [at_m, is_body] : cases) {
    Scene all = wall_and_actor();
    for (GaussianSet* const set : {&all.camera, &all.lidar}) {
      set->mean().row(1) = at_m.cast<float>().transpose();
      for (int k = 0; k < 3; ++k) set->log_scale()(1, k) = std::log(0.015F);
    }
    SceneOnDevice scene(test::device(), std::move(all));
    for (const Order order : {Order::kRange, Order::kPerRay}) {
      FrameRequest request{.options = RenderOptions{}, .actors = true};
      request.options->order = order;
      const Sensor sensor = still_camera().resized(480, 320);
      const Frame frame = scene.render(sensor, at_origin(sensor), request);
      const auto count = [](const std::vector<std::uint32_t>& of) {
        return std::count(of.begin(), of.end(), 2U);
      };
      EXPECT_GT(count(frame.owners()), 0) << at_m.transpose();
      EXPECT_EQ(count(frame.actors()), is_body ? count(frame.owners()) : 0) << at_m.transpose();
    }
  }
}

TEST(FrameActors, AreThereWhenAskedFor) {
  SceneOnDevice scene(test::device(), wall_and_actor());
  const Sensor sensor = still_camera();
  EXPECT_THROW((void)scene.render(sensor, at_origin(sensor)).actors(), Error);
  // Without actors all rays have actor 0.
  Scene nobody = wall_and_actor();
  nobody.actors.clear();
  nobody.camera.actor.clear();
  scene.set_scene(std::move(nobody));
  const std::vector<std::uint32_t> none = scene.render(sensor, at_origin(sensor), {.actors = true}).actors();
  EXPECT_EQ(none, std::vector<std::uint32_t>(sensor.ray_count(), 0));
}

}  // namespace
}  // namespace simuli

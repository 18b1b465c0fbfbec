// Tests that unused parts of a frame have no code and no memory: a part configured as absent gives the same
// programs, buffers and bits as a part never configured (bench/trade/plan.hpp measures the times).
#include <gtest/gtest.h>
#include <set>
#include <string>

#include "host/device/render/scene/appearance_on_device.hpp"
#include "host/device/runtime/device_state.hpp"
#include "tests/cl/support.hpp"
#include "tests/render/actor_scenes.hpp"

namespace simuli {
namespace plan_test {

/// Programs, buffers and results of a frame.
struct Traces {
  std::set<std::string> programs;
  std::uint64_t peak_bytes = 0;
  std::vector<double> outputs;
};

/// Renders on a separate device; with `scene` through its appearance, as the commands do.
Traces traces_of(const GaussianSet& set,
                 const test::Shot& shot,
                 const RenderOptions& options,
                 const Scene* scene = nullptr) {
  const Device device = Device::best();
  Renderer renderer(device, options);
  const ParticleBuffers particles(device, set, options);
  const SensorRays rays = shot.on(device, options);
  const auto through_appearance = [&] {
    AppearanceOnDevice appearance(device, *scene, options.precision);
    const Camera camera{.name = "camera"};  // has the scene's grid at any time
    return appearance.render(renderer, particles, rays, shot.view, &camera, Shot{});
  };
  const Pass pass = scene == nullptr ? renderer.render(particles, rays, shot.view) : through_appearance();
  Traces traces;
  traces.outputs = test::outputs(pass);
  traces.peak_bytes = device.memory().peak;
  for (const auto& [key, program] : device.state().programs) traces.programs.insert(key);
  return traces;
}

void expect_same(const Traces& absent, const Traces& never) {
  EXPECT_EQ(absent.programs, never.programs);
  EXPECT_EQ(absent.peak_bytes, never.peak_bytes);
  EXPECT_EQ(absent.outputs, never.outputs);
}

void expect_more(const Traces& present, const Traces& never) {
  EXPECT_NE(present.programs, never.programs);
  EXPECT_GT(present.peak_bytes, never.peak_bytes);
}

GaussianSet crowd(const test::SceneCase& scene) {
  return test::set_for(scene, {.count = 300, .low = {-8, -8, -3}, .high = {8, 8, 3}}, 5);
}

TEST(Plan, ShuttersOfSensorsAtRestAreNotThere) {
  const GaussianSet set = crowd(test::kCameraSh3);
  const test::Shot global = test::shot_of(test::kCameraSh3, 72, 50);
  test::Shot rolling = global;
  rolling.camera.shutter = ShutterKind::kTopToBottom;
  const Traces never = traces_of(set, global, paper_options());
  expect_same(traces_of(set, rolling, paper_options()), never);
  rolling.view.scene_from_sensor_end.translation.x() += 0.3;
  expect_more(traces_of(set, rolling, paper_options()), never);
}

TEST(Plan, ActorsWithoutParticlesAreNotThere) {
  GaussianSet set = crowd(test::kCameraSh3);
  test::Shot shot = test::shot_of(test::kCameraSh3, 72, 50);
  const Traces never = traces_of(set, shot, paper_options());
  shot.view.actors = test::cars(0.5, 0.1);
  expect_same(traces_of(set, shot, paper_options()), never);
  set.actor.assign(static_cast<std::size_t>(set.size()), 0);
  expect_same(traces_of(set, shot, paper_options()), never);
  set.actor[7] = 2;
  expect_more(traces_of(set, shot, paper_options()), never);
}

TEST(Plan, EmptyLooksAreNotThere) {
  const GaussianSet set = crowd(test::kCameraSh3);
  const test::Shot shot = test::shot_of(test::kCameraSh3, 72, 50);
  const Traces never = traces_of(set, shot, paper_options());
  Scene scene;
  expect_same(traces_of(set, shot, paper_options(), &scene), never);
  scene.color_grids = ColorGrids::identity(4, 4, 4, {{"camera", 0.0}});
  expect_more(traces_of(set, shot, paper_options(), &scene), never);
  scene.color_grids = {};
  scene.environment = {64, 32, std::vector<float>(std::size_t{64} * 32 * 3, 0.5F)};
  expect_more(traces_of(set, shot, paper_options(), &scene), never);
}

TEST(Plan, BandsThatAreLeftOutAreNotThere) {
  const GaussianSet set = crowd(test::kCameraSh3);
  GaussianSet plain(set.kind, 0, set.size());
  plain.params = set.params.leftCols(param_rows(0));
  const test::Shot shot = test::shot_of(test::kCameraSh3, 72, 50);
  const Traces never = traces_of(plain, shot, paper_options());
  RenderOptions options = paper_options();
  options.sh_degree = 0;
  expect_same(traces_of(set, shot, options), never);
  options.sh_direction = ShDirection::kRay;  // colours are equal in all directions
  expect_same(traces_of(set, shot, options), never);
  expect_more(traces_of(set, shot, paper_options()), never);
}

TEST(Plan, CamerasHaveNoMedianDistance) {
  const GaussianSet set = crowd(test::kCameraSh3);
  const test::Shot shot = test::shot_of(test::kCameraSh3, 72, 50);
  RenderOptions without = paper_options();
  without.median_distance = false;
  expect_same(traces_of(set, shot, paper_options()), traces_of(set, shot, without));
}

}  // namespace plan_test
}  // namespace simuli

// Tests actors with one recorded side: the other side shows the mirror image.
#include "host/core/record/mirror.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <numbers>

#include "host/core/base/error.hpp"
#include "host/device/render/scene/scene_on_device.hpp"
#include "tests/support/device.hpp"
#include "tests/support/scenes.hpp"

namespace simuli {
namespace {

constexpr double kAway_m = 8.0;

Pose facing(double y_m) {
  const double yaw = y_m > 0.0 ? -std::numbers::pi / 2.0 : std::numbers::pi / 2.0;
  const Pose stands{Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())), {0.0, y_m, 0.0}};
  return stands * test::forward_from_camera();
}

/// Returns a car at the origin with random particles on both sides, and background particles behind it.
Scene car_of_particles() {
  test::SetRecipe recipe;
  recipe.sh_degree = 3;
  recipe.count = 60;
  recipe.low = {-2.0, -1.0, -0.8};
  recipe.high = {2.0, 1.0, 0.8};
  recipe.sh_spread = 0.2;
  Scene scene;
  scene.camera = test::random_set(recipe, 5);
  recipe.kind = SetKind::kLidar;
  scene.lidar = test::random_set(recipe, 6);
  scene.camera.actor.assign(60, 1);
  scene.lidar.actor.assign(60, 1);
  scene.camera.actor[0] = scene.lidar.actor[0] = 0;
  Actor car{"car", "car", {5.0, 3.0, 2.0}, {}};
  car.track = {{0.0, {}}};
  scene.actors = {car};
  return scene;
}

SupportRecord seen_from(const std::vector<double>& sides_m) {
  SupportRecord record;
  const Camera camera = test::small_camera(48, 32);
  record.sensors = {{"camera", SetKind::kCamera, support_grid(camera)}};
  record.actors = car_of_particles().actors;
  for (const double y_m : sides_m)
    record.views.push_back({0, 0.0, facing(y_m) * grid_from_camera().inverse()});
  record.cells.resize(record.views.size() * record.sensors[0].grid.cells());
  return record;
}

TEST(MirrorActor, TheUnseenSideIsTheSeenOnesMirrorImage) {
  for (const double seen : {kAway_m, -kAway_m}) {
    Scene scene = car_of_particles();
    ASSERT_TRUE(mirror_actor(scene, seen_from({seen, seen}), "car", "car"));
    EXPECT_EQ(scene.camera.actor.size(), static_cast<std::size_t>(scene.camera.size()));
    scene.camera.params(0, kOpacityRow) = -80.0F;  // of the background
    SceneOnDevice on_device(test::device(), scene);
    const Sensor camera(test::small_camera(48, 32));
    const Image left = on_device.render(camera, Shot::at(facing(kAway_m), 0.0)).image();
    const Image right = on_device.render(camera, Shot::at(facing(-kAway_m), 0.0)).image();
    double largest = 0.0;
    for (int y = 0; y < left.height; ++y) {
      for (int x = 0; x < left.width; ++x) {
        for (int c = 0; c < 3; ++c) {
          EXPECT_NEAR(left.at(x, y, c), right.at(left.width - 1 - x, y, c), 2e-3);
          largest = std::max(largest, static_cast<double>(left.at(x, y, c)));
        }
      }
    }
    EXPECT_GT(largest, 0.3);
  }
}

TEST(MirrorActor, TheSeenSideAndTheBackgroundStay) {
  const Scene before = car_of_particles();
  Scene scene = before;
  ASSERT_TRUE(mirror_actor(scene, seen_from({kAway_m}), "car", "car"));
  Eigen::Index next = 0;
  for (Eigen::Index i = 0; i < before.camera.size(); ++i) {
    if (before.camera.actor[static_cast<std::size_t>(i)] == 1 && before.camera.mean()(i, 1) < 0.0F) continue;
    EXPECT_EQ(scene.camera.params.row(next), before.camera.params.row(i));
    ++next;
  }
  EXPECT_EQ(scene.camera.size(), 2 * next - 1);  // except the background particle
}

TEST(MirrorActor, NothingWhereBothSidesWereSeenOrNone) {
  for (const std::vector<double>& sides : {std::vector<double>{kAway_m, -kAway_m}, std::vector<double>{}}) {
    Scene scene = car_of_particles();
    EXPECT_FALSE(mirror_actor(scene, seen_from(sides), "car", "car"));
    EXPECT_EQ(scene.camera.params, car_of_particles().camera.params);
  }
  Scene scene = car_of_particles();
  EXPECT_THROW((void)mirror_actor(scene, seen_from({kAway_m}), "bus", "car"), Error);
  EXPECT_THROW((void)mirror_actor(scene, seen_from({kAway_m}), "car", "bus"), Error);
}

}  // namespace
}  // namespace simuli

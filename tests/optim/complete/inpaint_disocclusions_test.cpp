// Tests the inpainting of disocclusions: a wall, a moving car in front of it, and arbitrary trained particles
// behind the car.
#include "optim/complete/inpaint_disocclusions.hpp"

#include <gtest/gtest.h>

#include "host/core/scene/edit.hpp"
#include "host/core/scene/occluders.hpp"
#include "host/device/render/scene/scene_on_device.hpp"
#include "optim/complete/inpaint_views.hpp"
#include "tests/support/device.hpp"
#include "tests/support/scenes.hpp"

namespace simuli {
namespace {

constexpr double kWall_m = 20.0, kCar_m = 10.0, kBlob_m = 15.0;
const Eigen::Vector3d kOrigin{4096.0, 8192.0, 64.0};
const Eigen::Vector3d kWallLook{0.3, 0.6, 0.9}, kBlobLook{0.9, 0.1, 0.1}, kCarLook{0.8, 0.8, 0.1};

/// Returns a square of opaque particles across the x axis, `spacing_m` apart.
std::vector<test::SingleParticle> square(double x,
                                         double half_m,
                                         double spacing_m,
                                         const Eigen::Vector3d& look) {
  std::vector<test::SingleParticle> out;
  for (double y = -half_m; y <= half_m; y += spacing_m) {
    for (double z = -half_m; z <= half_m; z += spacing_m) {
      out.push_back(
          {{x, y, z}, {0.02, 0.7 * spacing_m, 0.7 * spacing_m}, Eigen::Quaterniond::Identity(), 0.97, look});
    }
  }
  return out;
}

bool is_hidden(const Eigen::Vector3d& p) { return std::abs(p.y()) < 2.4 && std::abs(p.z()) < 2.4; }

/// Returns the wall with a hole behind the car, in which there is a blob of another colour.
GaussianSet set_of(SetKind kind) {
  std::vector<test::SingleParticle> all;
  for (const test::SingleParticle& p : square(kWall_m, 9.0, 0.4, kWallLook)) {
    if (!is_hidden(p.mean)) all.push_back(p);
  }
  const std::vector<test::SingleParticle> blob = square(kBlob_m, 1.0, 0.4, kBlobLook);
  const std::vector<test::SingleParticle> car = square(0.0, 1.6, 0.2, kCarLook);
  all.insert(all.end(), blob.begin(), blob.end());
  all.insert(all.end(), car.begin(), car.end());
  GaussianSet set = test::set_of(kind, all);
  set.actor.assign(all.size(), 0);
  std::fill(set.actor.end() - static_cast<std::ptrdiff_t>(car.size()), set.actor.end(), 1);
  return set;
}

/// The rig and the car rest for half a second.
Log stand() {
  Log log;
  log.name = "stand";
  log.cameras = {{test::small_camera(96, 64), test::forward_from_camera()}};
  log.cameras[0].model.name = "front";
  Lidar lidar = test::small_lidar(24, 360);
  lidar.name = "top";
  log.lidars = {{lidar, {}}};
  const Pose there{Eigen::Quaterniond::Identity(), kOrigin};
  log.world_from_rig = Trajectory({{0.0, there}, {1.0, there}});
  for (int i = 0; i < 4; ++i) {
    const double time_s = 0.1 * i;
    log.images.push_back({"front", "none", time_s, time_s});
    log.sweeps.push_back({"top", "none", time_s, time_s + 0.1});
  }
  return log;
}

SceneFile trained() {
  const Log log = stand();
  SceneFile file{{}, log.cameras, log.lidars, log.world_from_rig, {}};
  file.scene.origin = kOrigin;
  file.scene.camera = set_of(SetKind::kCamera);
  file.scene.lidar = set_of(SetKind::kLidar);
  file.scene.lidar_background = {0.5F, -4.0F, 4.0F};
  Actor car{"car", "car", {0.4, 3.4, 3.4}, {}};
  for (const double time_s : {0.0, 1.0}) {
    car.track.push_back(
        {time_s, {Eigen::Quaterniond::Identity(), kOrigin + Eigen::Vector3d(kCar_m, 0.0, 0.0)}});
  }
  file.scene.actors = {car};
  return file;
}

SceneFile filled() {
  SceneFile file = trained();
  inpaint_behind_actors(test::device(), stand(), {{.image_scale = 1.0, .held_out_every = 0}, {}, {}}, file);
  return file;
}

/// Content straight ahead.
struct Ahead {
  double range_m, transmittance;
  Eigen::Vector3d look;
};
Ahead ahead(const Scene& scene, const Sensor& sensor) {
  SceneOnDevice on_device(test::device(), borrowed(scene));
  const Frame frame =
      on_device.render(sensor, Shot::at(sensor, {Eigen::Quaterniond::Identity(), kOrigin}, 0.2));
  const RayResults& rays = frame.results();
  std::size_t middle = sensor.rows() / 2 * sensor.columns() + sensor.columns() / 2;
  if (!sensor.is_camera()) {
    double best = 0.0;
    for (std::size_t i = 0; i < sensor.ray_count(); ++i) {
      const double along = Lidar::direction(static_cast<double>(sensor.rays().azimuth[i]),
                                            static_cast<double>(sensor.rays().elevation[i]))
                               .x();
      if (along > best) best = along, middle = i;
    }
  }
  return {static_cast<double>(rays.expected_distance(middle)),
          static_cast<double>(rays.transmittance[middle]),
          {static_cast<double>(rays.feature[0][middle]),
           static_cast<double>(rays.feature[1][middle]),
           static_cast<double>(rays.feature[2][middle])}};
}

std::vector<Sensor> sensors() {
  const Log log = stand();
  return {Sensor(log.cameras[0].model, log.cameras[0].rig_from_camera), Sensor(log.lidars[0].model)};
}

TEST(FillBehindActors, ShowsTheWallWhereTheCarWas) {
  SceneFile before = trained(), after = filled();
  ASSERT_EQ(after.scene.occluders.size(), 1U);
  EXPECT_EQ(after.scene.occluders[0].name, "car");
  for (const Sensor& sensor : sensors()) {
    SCOPED_TRACE(sensor.name());
    Scene without = before.scene;
    remove_actor(without, "car");
    EXPECT_NEAR(ahead(without, sensor).range_m, kBlob_m, 0.5);  // before inpainting
    EXPECT_NEAR(ahead(after.scene, sensor).range_m, kCar_m, 0.5);
    without = after.scene;
    remove_actor(without, "car");
    const Ahead seen = ahead(without, sensor);
    EXPECT_LT(seen.transmittance, 0.1);
    EXPECT_NEAR(seen.range_m, kWall_m, 0.6);
    EXPECT_NEAR(seen.look.x(), kWallLook.x(), 0.05);
    if (!sensor.is_camera()) continue;
    EXPECT_NEAR(seen.look.z(), kWallLook.z(), 0.1);
  }
}

TEST(FillBehindActors, RecordedViewsStayAsTheyAre) {
  const Scene before = trained().scene, after = filled().scene;
  for (const Sensor& sensor : sensors()) {
    SCOPED_TRACE(sensor.name());
    SceneOnDevice old_one(test::device(), borrowed(before)), new_one(test::device(), borrowed(after));
    const Shot shot = Shot::at(sensor, {Eigen::Quaterniond::Identity(), kOrigin}, 0.2);
    const RayResults a = old_one.render(sensor, shot).results(), b = new_one.render(sensor, shot).results();
    // Equal except for the order of particles at equal distances.
    for (std::size_t i = 0; i < a.rays; ++i) {
      ASSERT_NEAR(a.transmittance[i], b.transmittance[i], 1e-3);
      ASSERT_NEAR(a.distance[i], b.distance[i], 5e-3);
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(a.feature[c][i], b.feature[c][i], 1e-3);
    }
  }
}

TEST(FillBehindActors, IsTheSameAgain) {
  const Scene a = filled().scene, b = filled().scene;
  EXPECT_EQ(a.camera.params, b.camera.params);
  EXPECT_EQ(a.camera.actor, b.camera.actor);
  EXPECT_EQ(a.lidar.params, b.lidar.params);
  EXPECT_EQ(a.lidar.actor, b.lidar.actor);
}

TEST(FillBehindActors, NothingWithoutActors) {
  SceneFile file = trained();
  remove_actor(file.scene, "car");
  const Eigen::MatrixXf params = file.scene.camera.params;
  inpaint_behind_actors(test::device(), stand(), {{.image_scale = 1.0}, {}, {}}, file);
  EXPECT_TRUE(file.scene.occluders.empty());
  EXPECT_EQ(file.scene.camera.params, params);
  EXPECT_TRUE(file.scene.camera.actor.empty());
}

TEST(ActorsBefore, AreTheSameOfEveryRay) {
  for (const std::vector<std::uint32_t>& actors :
       {std::vector<std::uint32_t>{0, 0, 3, 3, 1, 0, 2}, {5, 0, 0}, {0, 0, 0}, {7, 7}}) {
    const ActorsBefore before(actors);
    EXPECT_EQ(before.of(actors.size()), actors);
    EXPECT_EQ(before.any(), actors[0] + actors[1] > 0 || actors.size() > 3);
  }
}

TEST(SeenWeights, AreThoseOfTheRaysThatAreCounted) {
  // One opaque particle in two cases: in front of an actor, and beside it in that view.
  GaussianSet one =
      test::set_of(SetKind::kCamera,
                   {{{10.0, 0.0, 0.0}, {0.1, 0.1, 0.1}, Eigen::Quaterniond::Identity(), 0.9, kWallLook}});
  const Log log = stand();
  const std::vector<InpaintView> views =
      inpaint_views(log, {.image_scale = 1.0, .held_out_every = 0}, SetKind::kCamera, 2);
  ASSERT_EQ(views.size(), 2U);
  EXPECT_DOUBLE_EQ(views[1].shot.time_start_s, 0.2);  // evenly spaced
  const std::size_t rays = views[0].sensor().ray_count();
  const SeenWeights seen = seen_weights(
      test::device(), one, views, {ActorsBefore(std::vector<std::uint32_t>(rays, 1)), {}}, kOrigin, {});
  SceneOnDevice on_device(test::device(), [&] {
    Scene scene;
    scene.origin = kOrigin;
    scene.camera = one;
    return scene;
  }());
  const RayResults all = on_device.render(views[0].sensor(), views[0].shot).results();
  double weight = 0.0;
  for (const float left : all.transmittance) weight += 1.0 - static_cast<double>(left);
  ASSERT_GT(weight, 1.0);
  EXPECT_NEAR(seen.before_actors(0), weight, 1e-3 * weight);
  EXPECT_NEAR(seen.elsewhere(0), weight, 1e-3 * weight);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(0.5 + seen.look(0, c) / seen.elsewhere(0), kWallLook[c], 1e-4);
}

}  // namespace
}  // namespace simuli

// Tests partially resident sets: equal bits as with the complete set on the device.
#include "host/device/render/pages/particle_pages.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "bench/particles/particle_street.hpp"
#include "host/core/base/angles.hpp"
#include "host/device/render/frame/actor_constants.hpp"
#include "host/device/render/scene/renderer.hpp"
#include "host/device/render/scene/scene_on_device.hpp"
#include "tests/cl/support.hpp"
#include "tests/host/expect_error.hpp"
#include "tests/render/actor_scenes.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

using Eigen::Vector3d;
using test::SceneCase;

constexpr double kLength_m = 1600.0;
constexpr Eigen::Index kParticles = 40'000;

std::shared_ptr<const GaussianSet> street(const SceneCase& scene) {
  return std::make_shared<const GaussianSet>(
      street_particles(scene.kind, scene.sh_degree, kParticles, 1, StreetOrder::kCoherent, kLength_m));
}

/// A sensor that moves along the street; cameras point across it, otherwise all particles ahead would be
/// visible.
class Drive {
 public:
  Drive(const Device& device, const SceneCase& scene, RenderOptions options)
      : shot_(scene.kind == SetKind::kCamera ? test::shot_of(scene, 64, 48) : test::shot_of(scene, 120, 16)),
        renderer_(device, options),
        rays_(shot_.on(device, renderer_.options())) {
    const Eigen::AngleAxisd across(scene.kind == SetKind::kCamera ? kPi / 2 : 0.0, Vector3d::UnitZ());
    for (Pose* const pose : {&shot_.view.scene_from_sensor_start, &shot_.view.scene_from_sensor_end}) {
      pose->rotation = across * pose->rotation;
      pose->translation.z() = 1.9;
    }
  }

  [[nodiscard]] View at(double x_m) const {
    View view = shot_.view;
    view.scene_from_sensor_end.translation.x() += x_m - view.scene_from_sensor_start.translation.x();
    view.scene_from_sensor_start.translation.x() = x_m;
    return view;
  }
  template <class Particles>
  std::vector<double> seen(Particles& particles, const View& view) {
    return test::outputs(renderer_.render(particles, rays_, view));
  }
  [[nodiscard]] const RenderOptions& options() const { return renderer_.options(); }
  [[nodiscard]] const SensorRays& rays() const { return rays_; }

 private:
  test::Shot shot_;
  Renderer renderer_;
  SensorRays rays_;
};

/// Positions forward, back, and far away.
constexpr double kPlaces_m[] = {-700, -660, -620, -500, -460, -500, -620, 300, 340, 380, -700};

void expect_same_along(const SceneCase& scene, const RenderOptions& options, std::uint32_t places) {
  SCOPED_TRACE(scene.name);
  const Device& device = test::device();
  Drive drive(device, scene, options);
  const auto set = street(scene);
  ParticleBuffers all(device, *set, drive.options());
  ParticlePages pages(device, set, drive.options(), places);
  ASSERT_EQ(pages.places(), places);
  ASSERT_GT(pages.pages(), places + places / 2);
  std::uint32_t brought = 0;
  double sum = 0.0;
  for (const double x_m : kPlaces_m) {
    const std::vector<double> expected = drive.seen(all, drive.at(x_m));
    ASSERT_EQ(drive.seen(pages, drive.at(x_m)), expected) << x_m;
    EXPECT_GT(pages.seen(), 0U);
    brought += pages.brought();
    for (const double value : expected) sum += std::abs(value);
    // No transfer without a change.
    ASSERT_EQ(drive.seen(pages, drive.at(x_m)), expected) << x_m;
    EXPECT_EQ(pages.brought(), 0U);
  }
  EXPECT_GT(brought, places);  // places were reused
  EXPECT_GT(sum, 0.0);
}

TEST(ParticlePages, AFewPlacesGiveTheBitsOfAll) {
  for (const SceneCase& scene : {test::kCameraStill, test::kCameraRolling, test::kLidarMoving}) {
    expect_same_along(scene, {}, 8);
  }
}

TEST(ParticlePages, OfHalvesOfLevelsAndInOtherShapes) {
  RenderOptions halves, levels, gpu;
  halves.sh_storage = ShStorage::kHalf;
  levels.detail = 2.0;
  gpu.shape = test::kGpuShape;
  expect_same_along(test::kLidarStill, halves, 8);
  expect_same_along(test::kCameraRolling, levels, 12);
  expect_same_along(test::kCameraRolling, gpu, 8);
}

TEST(ParticlePages, InDouble) {
  SIMULI_NEEDS_DOUBLE(test::device());
  RenderOptions options;
  options.precision = Precision::kDouble;
  options.detail = 2.0;
  expect_same_along(test::kLidarMoving, options, 12);
}

/// Cars and a bending shape; all their particles follow the street's.
TEST(ParticlePages, WithActorsThatMoveAndBend) {
  const Device& device = test::device();
  for (const SceneCase& scene : {test::kCameraRolling, test::kLidarMoving}) {
    Drive drive(device, scene, {});
    GaussianSet set = *street(scene);
    const GaussianSet car = test::set_for(scene, {.count = 700}, 3);
    constexpr std::uint32_t kCars = 12;
    std::vector<ActorView> actors;
    GaussianSet with(scene.kind, scene.sh_degree, set.size() + kCars * car.size());
    with.params.topRows(set.size()) = set.params;
    with.actor.assign(static_cast<std::size_t>(set.size()), 0);
    for (std::uint32_t a = 0; a < kCars; ++a) {
      with.params.middleRows(set.size() + a * car.size(), car.size()) = car.params;
      with.actor.insert(with.actor.end(), static_cast<std::size_t>(car.size()), a + 1);
      ActorView view = test::cars(0.4, 0.1)[a % 2];
      for (Pose* const pose : {&view.scene_from_actor_start, &view.scene_from_actor_end})
        pose->translation.x() += -700.0 + 100.0 * a;
      view.is_there = a % 5 != 2;
      actors.push_back(view);
    }
    DeformationView& shape = actors[0].deformation;
    shape.nodes = {2, 3, 2};
    shape.half_m = {2.0, 1.0, 0.8};
    test::Random random(4);
    for (std::vector<double>* const offsets : {&shape.start_m, &shape.end_m}) {
      for (int i = 0; i < 36; ++i) offsets->push_back(random.uniform(-1.0, 1.0));
    }
    ParticleBuffers all(device, with, drive.options());
    ParticlePages pages(device, std::make_shared<const GaussianSet>(with), drive.options(), 11);
    std::uint32_t brought = 0;
    for (const double x_m : kPlaces_m) {
      View view = drive.at(x_m);
      view.actors = actors;
      ASSERT_EQ(drive.seen(pages, view), drive.seen(all, view)) << scene.name << " at " << x_m;
      brought += pages.brought();
    }
    EXPECT_GT(brought, 11U);
  }
}

TEST(ParticlePages, RefuseWhatDoesNotFitAndGoOn) {
  const Device& device = test::device();
  const SceneCase scene = test::kLidarStill;
  Drive drive(device, scene, {});
  const auto set = street(scene);
  ParticleBuffers all(device, *set, drive.options());
  ParticlePages pages(device, set, drive.options(), 2);
  expect_error(ErrorKind::kDevice, "particles that a frame may see, allowed 4096", [&] {
    (void)drive.seen(pages, drive.at(0.0));
  });
  // Beyond the end of the street, near and far: no visible particles.
  for (const double x_m : {830.0, 5000.0}) {
    EXPECT_EQ(drive.seen(pages, drive.at(x_m)), drive.seen(all, drive.at(x_m)));
    EXPECT_EQ(pages.seen() == 0, x_m > 1000.0);
  }
  expect_error(ErrorKind::kUsage, "render.particle_memory_mb: found room for 0 particles", [&] {
    ParticlePages(device, set, drive.options(), 0);
  });
  const auto none = std::make_shared<const GaussianSet>(scene.kind, scene.sh_degree, 0);
  ParticleBuffers none_there(device, *none, drive.options());
  ParticlePages no_pages(device, none, drive.options(), 2);
  EXPECT_EQ(drive.seen(no_pages, drive.at(0.0)), drive.seen(none_there, drive.at(0.0)));
}

TEST(ParticlePages, HaveNoGradients) {
  const Device& device = test::device();
  const SceneCase scene = test::kLidarStill;
  const test::Shot shot = test::shot_of(scene, 60, 8);
  Renderer renderer(device, {});
  const SensorRays rays = shot.on(device, renderer.options());
  ParticlePages pages(device, street(scene), renderer.options(), 20);
  Pass pass = renderer.render(pages, rays, shot.view);
  pass.set_output_gradients(std::vector<double>(5 * rays.grid().rays, 1e-2));
  RealBuffer gradients(device, "parameter gradients", Precision::kFloat);
  expect_error(ErrorKind::kUsage, "found a part of a set, allowed all of it on the device", [&] {
    pass.backward(pages.buffers(), gradients);
  });
  Buffer<std::uint32_t> largest(device, "largest", 100'000);
  expect_error(ErrorKind::kUsage, "found a part of a set", [&] { pass.raise_largest_weights(largest); });
}

TEST(Pages, AsManyAsFitInWhatIsAskedFor) {
  const Device& device = test::device();
  const auto set = street(test::kLidarStill);
  RenderOptions options;
  EXPECT_EQ(page_count(*set, options), 20U);  // 40 000 of 2048
  EXPECT_EQ(pages_that_fit(device, *set, options), 20U);
  options.particle_memory_mb = 3;
  // 38 rows, 16 values of a record, 16 bytes of a footprint, and a key.
  EXPECT_EQ(pages_that_fit(device, *set, options), (3U << 20U) / (38 * 4 + 64 + 16 + 4) / 2048);
  options.sh_storage = ShStorage::kHalf;
  EXPECT_EQ(pages_that_fit(device, *set, options), (3U << 20U) / (11 * 4 + 27 * 2 + 64 + 16 + 4) / 2048);
}

TEST(Pages, ASceneInLittleMemoryIsTheSame) {
  const Device& device = test::device();
  const auto set = street(test::kLidarStill);
  Scene scene;
  scene.lidar = *set;
  scene.camera = GaussianSet(SetKind::kCamera, 0, 0);
  scene.lidar_background = {0.5F, 2.0F, -2.0F};
  RenderOptions little;
  little.particle_memory_mb = 3;
  SceneOnDevice all(device, scene), some(device, scene, little);
  const Sensor lidar(test::small_lidar(16, 180));
  for (const double x_m : kPlaces_m) {
    const Pose pose{Eigen::Quaterniond::Identity(), {x_m, 0.0, 1.9}};
    const Shot shot = Shot::at(pose, 0.0, 0.1);
    const Frame frame = some.render(lidar, shot);
    const RayResults expected = all.render(lidar, shot).results(), found = frame.results();
    ASSERT_EQ(found.distance, expected.distance) << x_m;
    for (int k = 0; k < 3; ++k) ASSERT_EQ(found.feature[k], expected.feature[k]) << x_m;
  }
  // Gradients need the complete set, as long as they are requested.
  const Pose pose{Eigen::Quaterniond::Identity(), {0.0, 0.0, 1.9}};
  const Shot shot = Shot::at(pose, 0.0, 0.1);
  RayGradients ones;
  ones.distance.assign(lidar.ray_count(), 1.0F);
  const Eigen::MatrixXf found = some.gradients(some.render(lidar, shot), ones);
  EXPECT_EQ(found, all.gradients(all.render(lidar, shot), ones));
  EXPECT_EQ(found.rows(), kParticles);
  EXPECT_GT(found.cwiseAbs().maxCoeff(), 0.0F);
}

}  // namespace
}  // namespace simuli

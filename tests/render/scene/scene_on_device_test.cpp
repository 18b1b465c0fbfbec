#include "host/device/render/scene/scene_on_device.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <utility>

#include "host/core/base/error.hpp"
#include "host/core/base/fields.hpp"
#include "host/core/scene/occluders.hpp"
#include "host/core/scene/particle_order.hpp"
#include "host/device/render/options/quality.hpp"
#include "host/device/render/scene/appearance_on_device.hpp"
#include "host/device/render/scene/ray_cache.hpp"
#include "host/device/render/scene/renderer.hpp"
#include "tests/render/scene/two_cars.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

using test::shot_of;

const RenderOptions kBalanced = options_of(Quality::kBalanced);

void expect_same(const RayResults& a, const RayResults& b) {
  ASSERT_EQ(a.rays, b.rays);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(a.feature[c], b.feature[c]);
  EXPECT_EQ(a.transmittance, b.transmittance);
  EXPECT_EQ(a.distance, b.distance);
  EXPECT_EQ(a.median, b.median);
}

/// Returns the result of the renderer with manually assembled inputs.
RayResults by_hand(const Device& device, const Scene& scene, const Sensor& sensor, const Shot& shot) {
  Renderer renderer(device, kBalanced);
  const RenderOptions& options = renderer.options();
  const SetKind kind = sensor.is_camera() ? SetKind::kCamera : SetKind::kLidar;
  const ParticleBuffers particles(device, sensor.is_camera() ? scene.camera : scene.lidar, options);
  // The rays are a temporary object: the pass keeps the data of results().
  const Pass pass =
      renderer.render(particles,
                      sensor.is_camera() ? SensorRays(device, sensor.camera(), options)
                                         : SensorRays(device, sensor.lidar(), sensor.rays(), options),
                      view_of(scene, shot, kind));
  return pass.results();
}

TEST(SceneOnDevice, IsTheRendererWithEverythingInPlace) {
  const Device& device = test::device();
  SceneOnDevice made(device, test::two_cars());
  SceneOnDevice scene = std::move(made);
  for (const Sensor& sensor : {test::camera(), test::lidar()}) {
    const Shot shot = shot_of(sensor, 0.12);
    const Frame frame = scene.render(sensor, shot);
    expect_same(frame.results(), by_hand(device, test::two_cars(), sensor, shot));
    const std::vector<float>& left = frame.results().transmittance;
    EXPECT_LT(*std::min_element(left.begin(), left.end()), 0.5F);  // some particle is visible
  }
}

TEST(SceneOnDevice, TellsSensorsApart) {
  SceneOnDevice scene(test::device(), test::two_cars());
  const Sensor camera = test::camera();
  const Shot shot = shot_of(camera, 0.1);
  const Image image = scene.render(camera, shot).image();
  Camera wider = camera.camera();
  wider.fx = 20.0;
  EXPECT_NE(scene.render(Sensor(wider), shot).image().data, image.data);
  wider.width = 40;
  EXPECT_EQ(scene.render(Sensor(wider), shot).image().width, 40);
  EXPECT_EQ(scene.sensor_count(), 3U);
  // Recreated and mounted elsewhere: the same rays.
  EXPECT_EQ(scene.render(test::camera().named("other").mounted({}), shot).image().data, image.data);
  EXPECT_EQ(scene.sensor_count(), 3U);
  wider.fy = -1.0;
  EXPECT_THROW((void)Sensor(wider), Error);
}

TEST(SceneOnDevice, MakesTheTilesOfARigOnce) {
  const Device device = Device::best("", {.profiling = true});
  SceneOnDevice scene(device, test::two_cars());
  std::vector<Sensor> rig;
  for (int i = 0; i < 20; ++i) {
    Lidar lidar = test::small_lidar(8, 60);
    for (LidarRow& row : lidar.rows) row.azimuth_offset = 0.001 * i;
    rig.emplace_back(lidar);
  }
  const auto tilings = [&] {
    std::uint64_t launches = 0;
    for (const ProfileRow& row : device.profile().rows()) {
      if (row.kernel.starts_with("tiling")) launches += row.count;
    }
    return launches;
  };
  const auto render_all = [&] {
    for (const Sensor& sensor : rig) (void)scene.render(sensor, shot_of(sensor, 0.1));
  };
  (void)scene.render(rig.front(), shot_of(rig.front(), 0.1));
  const std::uint64_t once = tilings();
  EXPECT_GT(once, 0U);
  render_all();
  EXPECT_EQ(tilings(), 20 * once);
  render_all();
  render_all();
  EXPECT_EQ(tilings(), 20 * once);
}

TEST(SceneOnDevice, EditsOfAShotAreThoseOfAScene) {
  const Device& device = test::device();
  SceneOnDevice scene(device, test::two_cars());
  struct Case {
    const char* name;
    std::vector<ActorEdit> edits;
    void (*edit)(Scene&);
  };
  const std::vector<KeyPose> track = {
      {0.05, {Eigen::Quaterniond::Identity(), test::kOrigin + Eigen::Vector3d(5.0, -3.0, 0.0)}},
      {0.30, {Eigen::Quaterniond::Identity(), test::kOrigin + Eigen::Vector3d(7.0, -3.0, 0.0)}}};
  static std::vector<KeyPose> other;
  other = track;
  const Case cases[] = {
      {"removed", {{"near", ActorEdit::Remove{}}}, [](Scene& s) { remove_actor(s, "near"); }},
      {"both removed",
       {{"near", ActorEdit::Remove{}}, {"far", ActorEdit::Remove{}}},
       [](Scene& s) {
         remove_actor(s, "near");
         remove_actor(s, "far");
       }},
      {"moved",
       {{"far", ActorEdit::Move{{1.0, -2.0, 0.3}}}},
       [](Scene& s) {
         move_actor(s, "far", {1.0, -2.0, 0.3});
       }},
      {"retimed",
       {{"near", ActorEdit::Retime{0.5, 0.02}}},
       [](Scene& s) { retime_actor(s, "near", 0.5, 0.02); }},
      {"retracked and moved",
       {{"near", ActorEdit::Retrack{track}}, {"near", ActorEdit::Move{{0.5, 0.0, 0.0}}}},
       [](Scene& s) {
         retrack_actor(s, "near", other);
         move_actor(s, "near", {0.5, 0.0, 0.0});
       }}};
  for (const Sensor& sensor : {test::camera(), test::lidar()}) {
    Shot shot = shot_of(sensor, 0.13);
    const RayResults plain = scene.render(sensor, shot).results();
    for (const Case& c : cases) {
      SCOPED_TRACE(c.name);
      shot.edits = c.edits;
      const RayResults found = scene.render(sensor, shot).results();
      EXPECT_NE(found.transmittance, plain.transmittance);
      Scene edited = test::two_cars();
      c.edit(edited);
      shot.edits.clear();
      expect_same(found, SceneOnDevice(device, std::move(edited)).render(sensor, shot).results());
      expect_same(scene.render(sensor, shot).results(), plain);  // the scene is unchanged
    }
    shot.edits = {{"nobody", ActorEdit::Remove{}}};
    EXPECT_THROW((void)scene.render(sensor, shot), Error);
  }
}

/// Returns two_cars(), the first of which occludes every fifth particle of the background; every other fifth
/// is its inpainted set.
Scene two_cars_and_a_place() {
  Scene scene = test::two_cars();
  scene.occluders = {scene.actors[0]};
  for (GaussianSet* set : {&scene.camera, &scene.lidar}) {
    for (std::size_t i = 0; i < set->actor.size(); ++i) {
      if (set->actor[i] != 0) continue;
      if (i % 5 == 0) set->actor[i] = disoccluded_number(scene, 0);
      if (i % 5 == 1) set->actor[i] = inpainted_number(scene, 0);
    }
  }
  return scene;
}

TEST(SceneOnDevice, EditsShowWhatIsThereInsteadOfWhatWasHidden) {
  const Device& device = test::device();
  SceneOnDevice scene(device, two_cars_and_a_place());
  // The same without occluders: the remaining particles of each third of the background.
  const auto with = [&](const std::vector<std::uint32_t>& shown, bool removed) {
    Scene plain = two_cars_and_a_place();
    for (GaussianSet* set : {&plain.camera, &plain.lidar}) {
      std::vector<Eigen::Index> kept;
      for (std::size_t i = 0; i < set->actor.size(); ++i) {
        std::uint32_t& actor = set->actor[i];
        const bool is_shown = actor <= 2 || std::find(shown.begin(), shown.end(), actor) != shown.end();
        if (is_shown) kept.push_back(static_cast<Eigen::Index>(i));
        if (actor > 2) actor = 0;
      }
      *set = subset(*set, kept);
    }
    plain.occluders.clear();
    if (removed) remove_actor(plain, "near");
    return plain;
  };
  const std::uint32_t behind = disoccluded_number(scene.scene(), 0),
                      instead = inpainted_number(scene.scene(), 0);
  const auto expect_near = [](const RayResults& a, const RayResults& b) {
    ASSERT_EQ(a.rays, b.rays);
    for (std::size_t i = 0; i < a.rays; ++i) {
      ASSERT_NEAR(a.transmittance[i], b.transmittance[i], 1e-4);
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(a.feature[c][i], b.feature[c][i], 1e-3);
    }
  };
  for (const Sensor& sensor : {test::camera(), test::lidar()}) {
    SCOPED_TRACE(sensor.name());
    Shot shot = shot_of(sensor, 0.13);
    const Frame plain = scene.render(sensor, shot, {.actors = true});
    expect_near(plain.results(), SceneOnDevice(device, with({behind}, false)).render(sensor, shot).results());
    for (const std::uint32_t actor : plain.actors()) EXPECT_LE(actor, 2U);
    shot.edits = {{"near", ActorEdit::Remove{}}};
    const RayResults removed = scene.render(sensor, shot).results();
    shot.edits.clear();
    expect_near(removed, SceneOnDevice(device, with({instead}, true)).render(sensor, shot).results());
    Scene edited = two_cars_and_a_place();
    remove_actor(edited, "near");
    expect_same(removed, SceneOnDevice(device, std::move(edited)).render(sensor, shot).results());
  }
}

/// Returns two_cars() with a visibility set for each third of the background.
Scene two_cars_and_visibility_sets() {
  Scene scene = test::two_cars();
  for (const double x : {-1.5, 1.5, 6.5})
    scene.visibility_sets.push_back({{scene.origin + Eigen::Vector3d(x, 0.0, 0.0)}});
  for (GaussianSet* set : {&scene.camera, &scene.lidar}) {
    for (std::size_t i = 0; i < set->actor.size(); ++i) {
      if (set->actor[i] == 0) set->actor[i] = number_of_visibility_set(scene, i % 3);
    }
  }
  return scene;
}

TEST(SceneOnDevice, AVistaIsSeenFromItsPlaceAndFadesBeyond) {
  const Device& device = test::device();
  SceneOnDevice scene(device, two_cars_and_visibility_sets());
  // The same without visibility sets: particles with the opacity of this position.
  const auto plain_at = [](const std::vector<double>& shares) {
    Scene plain = two_cars_and_visibility_sets();
    for (GaussianSet* set : {&plain.camera, &plain.lidar}) {
      std::vector<Eigen::Index> kept;
      for (std::size_t i = 0; i < set->actor.size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        std::uint32_t& number = set->actor[i];
        const double share = number <= 2 ? 1.0 : shares[number - number_of_visibility_set(plain, 0)];
        if (number > 2) number = 0;
        if (share == 0.0) continue;
        kept.push_back(row);
        float& logit = set->params(row, kOpacityRow);
        const double opacity = share / (1.0 + std::exp(-static_cast<double>(logit)));
        if (share < 1.0) logit = static_cast<float>(std::log(opacity / (1.0 - opacity)));
      }
      *set = subset(*set, kept);
    }
    plain.visibility_sets.clear();
    return plain;
  };
  for (const Sensor& sensor : {test::camera(), test::lidar()}) {
    for (const double ahead_m : {-0.5, 1.2, 2.4, 4.0}) {
      SCOPED_TRACE(fmt::format("{} {}", sensor.name(), ahead_m));
      Shot shot = shot_of(sensor, 0.13);
      shot.world_from_sensor_start.translation.x() += ahead_m;
      shot.world_from_sensor_end.translation.x() += ahead_m;
      auto shares = visibility_shares(scene.scene().visibility_sets, shot.pose_at(0.5).translation);
      EXPECT_EQ(shares[0] > 0.0, ahead_m < 3.2);  // one fades out, one fades in
      EXPECT_EQ(shares[2] > 0.0, ahead_m > 0.6);
      if (!sensor.is_camera()) shares.assign(3, 1.0);  // LiDARs use all of them
      const Frame frame = scene.render(sensor, shot, {.actors = true});
      const RayResults found = frame.results();
      const RayResults expected = SceneOnDevice(device, plain_at(shares)).render(sensor, shot).results();
      ASSERT_EQ(found.rays, expected.rays);
      for (std::size_t i = 0; i < found.rays; ++i) {
        ASSERT_NEAR(found.transmittance[i], expected.transmittance[i], 1e-4);
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(found.feature[c][i], expected.feature[c][i], 1e-3);
      }
      for (const std::uint32_t actor : frame.actors()) EXPECT_LE(actor, 2U);
    }
  }
}

TEST(SceneOnDevice, QualitiesShareAScene) {
  const Device& device = test::device();
  SceneOnDevice scene(device, test::two_cars());
  for (const Sensor& sensor : {test::camera(), test::lidar()}) {
    const Shot shot = shot_of(sensor, 0.1);
    for (const Quality quality : {Quality::kDraft, Quality::kExact, Quality::kBalanced, Quality::kDraft}) {
      SceneOnDevice alone(device, test::two_cars(), options_of(quality));
      expect_same(scene.render(sensor, shot, {.options = options_of(quality)}).results(),
                  alone.render(sensor, shot).results());
    }
  }
  RenderOptions odd;
  odd.alpha_cut = 2.0;
  EXPECT_THROW((void)scene.render(test::camera(), shot_of(test::camera(), 0.1), {.options = odd}), Error);
  EXPECT_THROW(SceneOnDevice(device, test::two_cars(), odd), Error);
}

TEST(SceneOnDevice, PixelsAreAsWideAsTheSceneWasTrainedWithUnlessAsked) {
  const Device& device = test::device();
  const auto with = [&](double of_scene, double requested) {
    Scene scene = test::two_cars();
    scene.camera_filter_px2 = of_scene;
    RenderOptions options;
    options.camera_filter_px2 = requested;
    SceneOnDevice on_device(device, std::move(scene), options);
    return on_device.render(test::camera(), shot_of(test::camera(), 0.1)).results();
  };
  const RayResults own = with(0.3, kOfScene);
  expect_same(own, with(kPixelVariance_px2, 0.3));
  expect_same(with(kPixelVariance_px2, kOfScene), with(0.3, kPixelVariance_px2));
  EXPECT_NE(own.transmittance, with(0.3, kPixelVariance_px2).transmittance);
  // The rendered scene may change.
  Scene other = test::two_cars();
  other.camera_filter_px2 = 0.3;
  SceneOnDevice changing(device, test::two_cars());
  const Shot shot = shot_of(test::camera(), 0.1);
  (void)changing.render(test::camera(), shot);
  changing.set_scene(std::move(other));
  expect_same(changing.render(test::camera(), shot).results(), own);
}

TEST(SceneOnDevice, PicturesHaveWhatTheirSceneHasBesideParticles) {
  const Device& device = test::device();
  const Sensor camera = test::camera();
  const Shot shot = shot_of(camera, 0.1);
  Scene plain = test::two_cars();
  plain.environment = {8, 4, std::vector<float>(8 * 4 * 3, 0.7F)};
  Scene graded = plain;
  graded.color_grids = ColorGrids::identity(2, 2, 2, {{"front", shot.middle_s()}});
  for (float& value : graded.color_grids.values) value *= 0.5F;

  SceneOnDevice scene(device, graded);
  const RayResults seen = scene.render(camera, shot).results();
  Renderer renderer(device, kBalanced);
  const ParticleBuffers particles(device, graded.camera, renderer.options());
  AppearanceOnDevice appearance(device, graded, Precision::kFloat);
  const Pass pass = appearance.render(renderer,
                                      particles,
                                      SensorRays(device, camera.camera(), renderer.options()),
                                      view_of(graded, shot, SetKind::kCamera),
                                      &camera.camera(),
                                      shot);
  expect_same(seen, pass.results());

  const RayResults ungraded = SceneOnDevice(device, plain).render(camera, shot).results();
  EXPECT_NE(seen.feature[0], ungraded.feature[0]);
  expect_same(scene.render(camera, shot, {.graded = false}).results(), ungraded);
  Camera unknown = camera.camera();
  unknown.name = "never trained on";  // uses the mean colours of the others
  expect_same(scene.render(Sensor(unknown), shot).results(), seen);
  scene.set_scene(test::two_cars());  // a black background has no sky
  EXPECT_NE(scene.render(camera, shot).results().feature[0], ungraded.feature[0]);
}

TEST(SceneOnDevice, RendersTheRaysThatAreAskedFor) {
  SceneOnDevice scene(test::device(), test::two_cars());
  for (const Sensor& sensor : {test::camera(), test::lidar()}) {
    const Shot shot = shot_of(sensor, 0.1);
    const RayResults all = scene.render(sensor, shot).results();
    std::vector<bool> some(all.rays);
    for (std::size_t i = 0; i < some.size(); ++i) some[i] = i % 3 == 0;
    const RayResults part = scene.render(sensor, shot, {.rays = some}).results();
    for (std::size_t i = 0; i < some.size(); ++i) {
      ASSERT_EQ(part.transmittance[i], some[i] ? all.transmittance[i] : 1.0F) << i;
      if (!some[i]) continue;
      ASSERT_EQ(part.feature[0][i], all.feature[0][i]) << i;
    }
    expect_same(scene.render(sensor, shot).results(), all);
    EXPECT_THROW((void)scene.render(sensor, shot, {.rays = {true}}), Error);
  }
}

TEST(SceneOnDevice, MakesRaysAnewForWhatTheyDependOnAlone) {
  SceneOnDevice scene(test::device(), test::two_cars());
  const Sensor camera = test::camera();
  const Shot shot = shot_of(camera, 0.1);
  const auto rendered = [&](const std::string& setting, std::vector<bool> rays = {}) {
    RenderOptions options;
    fields_of(options).apply({setting});
    (void)scene.render(camera, shot, {.options = options, .rays = std::move(rays)}).results();
    return scene.sensor_count();
  };
  EXPECT_EQ(rendered("render.alpha_cut=0.02"), 1U);
  EXPECT_EQ(rendered("render.order=window"), 1U);
  EXPECT_EQ(rendered("render.camera_near_m=0.5"), 2U);
  EXPECT_EQ(rendered("render.camera_filter_px2=0.2"), 3U);
  EXPECT_EQ(rendered("render.precision=double"), 4U);
  const std::vector<bool> some(camera.ray_count(), false);
  EXPECT_EQ(rendered("render.alpha_cut=0.02", some), 5U);
  EXPECT_EQ(rendered("render.alpha_cut=0.03", some), 5U);
}

/// Cameras with distinct focal lengths.
TEST(RayCache, KeepsWhatComesBackAndLittleOfWhatDoesNot) {
  const Device& device = test::device();
  const RenderOptions options;
  std::size_t made = 0;
  const auto sensor_of = [](std::size_t number) {
    Camera camera = test::camera().camera();
    camera.fx += 0.01 * static_cast<double>(number);
    return Sensor(camera);
  };
  const std::size_t one = SensorRays(device, sensor_of(0).camera(), options).bytes();
  EXPECT_GT(one, sensor_of(0).ray_count() * (8 + 8 + 3) * sizeof(float));  // device, host, maps
  RayCache cache(40 * one + 40);
  const auto use = [&](std::size_t number) {
    const Sensor sensor = sensor_of(number);
    (void)cache.get({sensor, options.precision, options, {}}, [&] {
      ++made;
      return SensorRays(device, sensor.camera(), options);
    });
    EXPECT_LE(cache.used_bytes(), 40 * one + 40);
  };
  for (std::size_t number = 0; number < 100; ++number) use(number);
  EXPECT_EQ(made, 100U);
  EXPECT_EQ(cache.size(), 10U);  // a quarter
  for (std::size_t number = 90; number < 100; ++number) use(number);
  EXPECT_EQ(made, 100U);
  // evicted before their second use: recognised
  for (std::size_t number = 0; number < 20; ++number) use(number);
  EXPECT_EQ(made, 120U);
  for (std::size_t number = 100; number < 200; ++number) use(number);
  EXPECT_EQ(made, 220U);
  for (std::size_t number = 0; number < 20; ++number) use(number);
  for (std::size_t number = 90; number < 100; ++number) use(number);
  EXPECT_EQ(made, 220U);
}

TEST(SceneOnDevice, RaysAreOfAllScenesOfADevice) {
  SceneOnDevice one(test::device(), test::two_cars()), other(test::device(), test::two_cars());
  const Sensor camera = test::camera();
  const RayResults first = one.render(camera, shot_of(camera, 0.1)).results();
  const std::size_t kept = one.sensor_count();
  expect_same(other.render(camera, shot_of(camera, 0.1)).results(), first);
  EXPECT_EQ(other.sensor_count(), kept);
}

TEST(SceneOnDevice, RendersMeasuredRays) {
  const Device& device = test::device();
  SceneOnDevice scene(device, test::two_cars());
  const Sensor nominal = test::lidar();
  const Shot shot = shot_of(nominal, 0.1);
  LidarRays rays = nominal.rays();
  for (float& azimuth : rays.azimuth) azimuth += 0.003F;
  const Sensor measured = nominal.with_rays(rays);
  const Frame frame = scene.render(measured, shot);
  expect_same(frame.results(), by_hand(device, test::two_cars(), measured, shot));
  EXPECT_EQ(frame.lidar().rays.azimuth, rays.azimuth);
  EXPECT_NE(frame.results().transmittance, scene.render(nominal, shot).results().transmittance);
}

}  // namespace
}  // namespace simuli

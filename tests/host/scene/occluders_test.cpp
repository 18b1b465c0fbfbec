#include "host/core/scene/occluders.hpp"

#include <algorithm>
#include <gtest/gtest.h>

#include "host/core/scene/edit.hpp"

namespace simuli {
namespace {

/// Returns two cars at rest for two seconds; the second hides a particle and has an inpainted one.
Scene two_cars_and_a_place() {
  Scene scene;
  scene.origin = {100.0, 0.0, 0.0};
  scene.camera = GaussianSet(SetKind::kCamera, 0, 5);
  scene.camera.rotation().col(0).setOnes();
  for (Eigen::Index i = 0; i < 5; ++i) scene.camera.mean()(i, 0) = static_cast<float>(i);
  for (const double left_m : {0.0, 4.0}) {
    Actor car{left_m == 0.0 ? "first" : "second", "car", {4.0, 2.0, 1.5}, {}};
    for (const double time_s : {0.0, 2.0}) {
      car.track.push_back({time_s, {Eigen::Quaterniond::Identity(), {110.0, left_m, 0.0}}});
    }
    scene.actors.push_back(car);
  }
  scene.occluders = {scene.actors[1]};
  scene.camera.actor = {0, 1, 2, disoccluded_number(scene, 0), inpainted_number(scene, 0)};
  return scene;
}

std::vector<bool> shown(const Scene& scene, double time_s) {
  std::vector<bool> out;
  for (const ActorView& view : owners_during(scene, scene.actors, time_s, time_s, std::nullopt))
    out.push_back(view.is_there);
  return out;
}

TEST(Occluders, ShowWhatTheyHideUntilTheyAreElsewhere) {
  const Scene scene = two_cars_and_a_place();
  ASSERT_EQ(most_numbers(scene), 4U);
  EXPECT_EQ(shown(scene, 1.0), (std::vector<bool>{true, true, true, false}));
  // Not recorded at this time: the trained particles remain.
  EXPECT_EQ(shown(scene, 5.0), (std::vector<bool>{false, false, true, false}));
  const std::vector<ActorView> views = owners_during(scene, scene.actors, 1.0, 1.0, std::nullopt);
  EXPECT_TRUE(views[2].scene_from_actor_start.translation.isZero());
  EXPECT_TRUE(views[3].scene_from_actor_end.translation.isZero());
}

TEST(Occluders, AreAwayWhenAnyEditTakesThemFromTheirPlace) {
  struct Case {
    const char* name;
    void (*edit)(Scene&);
    bool away;
  };
  const std::vector<Case> cases = {
      {"nothing", [](Scene&) {}, false},
      {"another one", [](Scene& s) { remove_actor(s, "first"); }, false},
      {"removed", [](Scene& s) { remove_actor(s, "second"); }, true},
      {"a breath",
       [](Scene& s) {
         move_actor(s, "second", {0.05, 0.0, 0.0});
       },
       false},
      {"moved",
       [](Scene& s) {
         move_actor(s, "second", {0.0, 0.5, 0.0});
       },
       true},
      {"turned", [](Scene& s) { turn_actor(s, "second", 0.2); }, true},
      {"later", [](Scene& s) { retime_actor(s, "second", 1.0, 5.0); }, true},
      {"smaller", [](Scene& s) { resize_actor(s, "second", 0.97); }, true},
      {"as it was",
       [](Scene& s) { retrack_actor(s, "second", std::vector<KeyPose>(s.occluders[0].track)); },
       false}};
  for (const Case& c : cases) {
    Scene scene = two_cars_and_a_place();
    c.edit(scene);
    EXPECT_EQ(is_away(scene.occluders[0], scene.actors, 1.0, 1.0), c.away) << c.name;
    const std::vector<bool> now = shown(scene, 1.0);
    ASSERT_EQ(now.size(), most_numbers(scene)) << c.name;
    EXPECT_EQ(now[disoccluded_number(scene, 0) - 1], !c.away) << c.name;
    EXPECT_EQ(now[inpainted_number(scene, 0) - 1], c.away) << c.name;
  }
}

TEST(Occluders, KeepTheirParticlesWhenActorsComeAndGo) {
  Scene scene = two_cars_and_a_place();
  const auto means_of = [&](std::uint32_t number) {
    std::vector<float> means;
    for (std::size_t i = 0; i < scene.camera.actor.size(); ++i) {
      if (scene.camera.actor[i] == number)
        means.push_back(scene.camera.mean()(static_cast<Eigen::Index>(i), 0));
    }
    return means;
  };
  const auto expect_own = [&](const char* when) {
    EXPECT_EQ(means_of(disoccluded_number(scene, 0)), std::vector<float>{3.0F}) << when;
    EXPECT_EQ(means_of(inpainted_number(scene, 0)), std::vector<float>{4.0F}) << when;
    EXPECT_LE(*std::max_element(scene.camera.actor.begin(), scene.camera.actor.end()), most_numbers(scene));
  };
  duplicate_actor(scene, "first", "third");
  expect_own("a copy");
  EXPECT_EQ(means_of(3), std::vector<float>{1.0F});
  remove_actor(scene, "first");
  expect_own("one less");
  EXPECT_EQ(means_of(1), std::vector<float>{2.0F});
  add_actor(scene, two_cars_and_a_place(), "first", "guest");
  expect_own("a guest");
  remove_actor(scene, "second");
  expect_own("the occluder gone");
}

TEST(Occluders, AreNoActorsThatHoldASetsSize) {
  Scene scene = two_cars_and_a_place();
  EXPECT_TRUE(has_particles_of_actors(scene, scene.camera));
  EXPECT_FALSE(has_particles_of_actors(scene, scene.lidar));
  remove_actor(scene, "first");
  EXPECT_TRUE(has_particles_of_actors(scene, scene.camera));
  remove_actor(scene, "second");
  EXPECT_FALSE(has_particles_of_actors(scene, scene.camera));
  EXPECT_FALSE(scene.camera.actor.empty());
}

TEST(Occluders, AreSeenThroughInSetsWithoutActors) {
  Scene scene = two_cars_and_a_place();
  // Without actors the disoccluded particles are visible.
  const GaussianSet background = background_of(scene, SetKind::kCamera);
  ASSERT_EQ(background.size(), 2);
  EXPECT_EQ(background.mean()(1, 0), 4.0F);
  // As recorded, with both cars: all but the inpainted particle.
  const GaussianSet then = moment_of(scene, SetKind::kCamera, 1.0);
  ASSERT_EQ(then.size(), 4);
  EXPECT_EQ(then.mean()(3, 0), 3.0F);
  remove_actor(scene, "second");
  const GaussianSet without = moment_of(scene, SetKind::kCamera, 1.0);
  ASSERT_EQ(without.size(), 3);
  EXPECT_EQ(without.mean()(2, 0), 4.0F);
}

}  // namespace
}  // namespace simuli

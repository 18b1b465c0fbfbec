#include "host/core/scene/edit.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "tests/host/expect_error.hpp"

namespace simuli {
namespace edit_test {

using Eigen::Vector3d;

constexpr double kExact = 1e-12;

/// Returns two cars; the first parameter of particle i of a set is i.
Scene two_cars() {
  Scene scene;
  Actor car;
  car.name = "first";
  car.kind = "car";
  car.size_m = {4.0, 1.8, 1.5};
  const Eigen::Quaterniond left(Eigen::AngleAxisd(std::acos(0.0), Vector3d::UnitZ()));
  car.track = {{1.0, {left, {10, 0, 0}}}, {2.0, {left, {10, 8, 0}}}};
  scene.actors.push_back(car);
  car.name = "second";
  scene.actors.push_back(car);
  scene.camera = GaussianSet(SetKind::kCamera, 1, 5);
  scene.lidar = GaussianSet(SetKind::kLidar, 0, 3);
  for (GaussianSet* set : {&scene.camera, &scene.lidar}) {
    for (Eigen::Index i = 0; i < set->size(); ++i) set->params(i, 0) = static_cast<float>(i);
  }
  scene.camera.actor = {0, 1, 2, 1, 0};
  scene.lidar.actor = {2, 0, 2};
  return scene;
}

TEST(Edit, OfTracksAloneIsTheSameFunction) {
  const std::vector<Actor> actors = two_cars().actors;
  Scene scene = two_cars();
  move_actor(scene, "second", {1.0, -2.0, 0.5});
  retime_actor(scene, "second", 2.0, 0.25);
  const std::vector<Actor> after = edited(
      actors, {{"second", ActorEdit::Move{{1.0, -2.0, 0.5}}}, {"second", ActorEdit::Retime{2.0, 0.25}}});
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(after[1].track[k].time_s, scene.actors[1].track[k].time_s);
    EXPECT_EQ(after[1].track[k].world_from_actor.translation,
              scene.actors[1].track[k].world_from_actor.translation);
  }
  const std::vector<Actor> gone = edited(actors, {{"first", ActorEdit::Remove{}}});
  EXPECT_FALSE(gone[0].is_there(1.5));
  EXPECT_TRUE(gone[1].is_there(1.5));
  // Later edits have no effect.
  EXPECT_TRUE(edited(gone, {{"first", ActorEdit::Retime{2.0, 0.0}}})[0].track.empty());
  expect_error(ErrorKind::kUsage, "third", [&] { (void)edited(actors, {{"third", ActorEdit::Remove{}}}); });
  expect_error(ErrorKind::kUsage, "0.001 to 1000", [&] {
    (void)edited(actors, {{"first", ActorEdit::Retime{0.0, 0.0}}});
  });
}

TEST(Edit, RemovesAnActorWithItsParticles) {
  Scene scene = two_cars();
  remove_actor(scene, "first");
  ASSERT_EQ(scene.actors.size(), 1U);
  EXPECT_EQ(scene.actors[0].name, "second");
  EXPECT_EQ(scene.camera.actor, (std::vector<std::uint32_t>{0, 1, 0}));
  EXPECT_EQ(scene.camera.params.col(0), Eigen::Vector3f(0, 2, 4));
  EXPECT_EQ(scene.lidar.actor, (std::vector<std::uint32_t>{1, 0, 1}));
  remove_actor(scene, "second");
  EXPECT_TRUE(scene.camera.actor.empty());
  EXPECT_EQ(scene.camera.size(), 2);
  EXPECT_EQ(scene.lidar.size(), 1);
}

TEST(Edit, MovesInTheActorsOwnFrame) {
  Scene scene = two_cars();
  move_actor(scene, "second", {1.0, 2.0, 0.5});
  EXPECT_TRUE(scene.actors[1].at(1.5).translation.isApprox(Vector3d(8.0, 5.0, 0.5), kExact));
  EXPECT_TRUE(scene.actors[0].at(1.5).translation.isApprox(Vector3d(10.0, 4.0, 0.0), kExact));
}

TEST(Edit, TurnsAboutItsOwnUp) {
  Scene scene = two_cars();
  turn_actor(scene, "second", std::acos(0.0));  // its front, which pointed to +y, now points to -x
  EXPECT_TRUE((scene.actors[1].at(1.5) * Vector3d(1, 0, 0)).isApprox(Vector3d(9, 4, 0), kExact));
  EXPECT_TRUE((scene.actors[1].at(1.5) * Vector3d(0, 0, 1)).isApprox(Vector3d(10, 4, 1), kExact));
  expect_error(ErrorKind::kUsage, "finite", [&] { turn_actor(scene, "first", std::nan("")); });
}

TEST(Edit, ResizesOnItsBase) {
  Scene scene = two_cars();
  resize_actor(scene, "first", 2.0);
  EXPECT_EQ(scene.actors[0].size_m, Vector3d(8.0, 3.6, 3.0));
  // The base remains at -0.75.
  EXPECT_TRUE(scene.actors[0].at(1.5).translation.isApprox(Vector3d(10, 4, 0.75), kExact));
  EXPECT_EQ(scene.camera.params(3, 0), 6.0F);
  EXPECT_EQ(scene.camera.params(2, 0), 2.0F);  // of the other car
  EXPECT_NEAR(scene.camera.log_scale()(3, 1), std::log(2.0F), 1e-6F);
  EXPECT_EQ(scene.camera.log_scale()(2, 1), 0.0F);
  expect_error(ErrorKind::kUsage, "found 0 times", [&] { resize_actor(scene, "first", 0.0); });
  const Eigen::Vector3d size_m = scene.actors[0].size_m;
  for (const double factor : {30.0, 1e3, 1e36, 1e300}) {  // the limits of boxes in files
    expect_error(ErrorKind::kInput, "resize: first: size", [&] { resize_actor(scene, "first", factor); });
  }
  EXPECT_EQ(scene.actors[0].size_m, size_m);
  for (const std::string& name : {std::string("../../x"),
                                  std::string("a/b"),
                                  std::string("a\\b"),
                                  std::string(".a"),
                                  std::string("a\nb"),
                                  std::string("\xE2\x80\xAE"
                                              "b"),
                                  std::string("\xC2\x9B"),
                                  std::string(),
                                  std::string(129, 'a')}) {
    expect_error(ErrorKind::kInput, "name", [&] { duplicate_actor(scene, "first", name); });
    expect_error(ErrorKind::kInput, "name", [&] { add_actor(scene, two_cars(), "first", name); });
  }
}

TEST(Edit, RetimesFromTheStartOfTheTrack) {
  Scene scene = two_cars();
  retime_actor(scene, "first", 2.0, 0.25);
  EXPECT_TRUE(scene.actors[0].at(1.5).translation.isApprox(Vector3d(10.0, 4.0, 0.0), kExact));
  EXPECT_FALSE(scene.actors[0].is_there(1.1));
  for (const auto& [rate, delay_s] :
       {std::pair{0.0, 0.0}, {1e300, 0.0}, {NAN, 0.0}, {1.0, 1e300}, {1.0, NAN}}) {
    expect_error(ErrorKind::kUsage, "times as fast", [&] { retime_actor(scene, "first", rate, delay_s); });
  }
}

TEST(Edit, SendsAnActorElsewhere) {
  Scene scene = two_cars();
  retrack_actor(scene, "first", {{0.0, {Eigen::Quaterniond::Identity(), {1, 2, 3}}}});
  EXPECT_TRUE(scene.actors[0].at(0.0).translation.isApprox(Vector3d(1, 2, 3), kExact));
  expect_error(ErrorKind::kInput, "track", [&] { retrack_actor(scene, "first", {}); });
  EXPECT_EQ(scene.actors[0].track.size(), 1U);
}

TEST(Edit, DuplicatesWithParticles) {
  Scene scene = two_cars();
  duplicate_actor(scene, "first", "third");
  ASSERT_EQ(scene.actors.size(), 3U);
  EXPECT_EQ(scene.camera.actor, (std::vector<std::uint32_t>{0, 1, 2, 1, 0, 3, 3}));
  EXPECT_EQ(scene.camera.params(5, 0), 1.0F);
  EXPECT_EQ(scene.camera.params(6, 0), 3.0F);
  EXPECT_EQ(scene.lidar.size(), 3);
  expect_error(ErrorKind::kUsage, "\"second\"", [&] { duplicate_actor(scene, "first", "second"); });
  expect_error(ErrorKind::kUsage, "allowed first, second, third", [&] { remove_actor(scene, "bus"); });
}

TEST(Edit, AddsAnActorOfAnotherScene) {
  Scene scene;
  scene.camera = GaussianSet(SetKind::kCamera, 0, 2);  // without the bands of degree 1
  scene.lidar = GaussianSet(SetKind::kLidar, 1, 1);    // with bands that the other does not have
  Scene other = two_cars();
  other.camera.params.row(2).setConstant(7.0F);
  add_actor(scene, other, "second", "guest");
  ASSERT_EQ(scene.actors.size(), 1U);
  EXPECT_EQ(scene.actors[0].name, "guest");
  EXPECT_EQ(scene.camera.actor, (std::vector<std::uint32_t>{0, 0, 1}));
  EXPECT_EQ(scene.camera.params.cols(), param_rows(0));
  EXPECT_TRUE((scene.camera.params.row(2).array() == 7.0F).all());
  EXPECT_EQ(scene.lidar.actor, (std::vector<std::uint32_t>{0, 1, 1}));
  EXPECT_EQ(scene.lidar.params(2, 0), 2.0F);
  EXPECT_TRUE((scene.lidar.params.rightCols(9).array() == 0.0F).all());
}

Scene with_a_walker() {
  Scene scene = two_cars();
  Deformation& shape = scene.actors[1].deformation;
  shape.nodes = {2, 2, 2};
  shape.start_s = 1.0;
  shape.interval_s = 0.25;
  for (int i = 0; i < 5 * 24; ++i) shape.offsets_m.push_back(0.01 * (i * i % 37));
  return scene;
}

TEST(Edit, TakesShapesAlong) {
  const Scene before = with_a_walker();
  const Deformation& recorded = before.actors[1].deformation;
  Scene scene = before;
  // Twice as fast and half a second later: the pose of 1.6 s is at 1.5 + 0.3 s.
  retime_actor(scene, "second", 2.0, 0.5);
  const std::vector<double> at = scene.actors[1].deformation.at(1.8), was = recorded.at(1.6);
  for (std::size_t i = 0; i < at.size(); ++i) EXPECT_NEAR(at[i], was[i], kExact);
  move_actor(scene, "second", {1.0, 0.0, 0.0});
  turn_actor(scene, "second", 0.3);
  EXPECT_EQ(scene.actors[1].deformation.offsets_m, recorded.offsets_m);
  duplicate_actor(scene, "second", "third");
  EXPECT_EQ(scene.actors[2].deformation.offsets_m, recorded.offsets_m);
  resize_actor(scene, "third", 2.0);
  EXPECT_NEAR(scene.actors[2].deformation.offsets_m[5], 2.0 * recorded.offsets_m[5], kExact);
  EXPECT_EQ(scene.actors[1].deformation.offsets_m[5], recorded.offsets_m[5]);
  remove_actor(scene, "second");
  EXPECT_EQ(scene.actors[1].name, "third");
  EXPECT_EQ(scene.actors[1].deformation.offsets_m.size(), recorded.offsets_m.size());
  // A new track starts with the first shape of the old track.
  Scene again = before;
  std::vector<KeyPose> track = before.actors[1].track;
  for (KeyPose& key : track) key.time_s += 7.0;
  retrack_actor(again, "second", track);
  const std::vector<double> later = again.actors[1].deformation.at(8.3), first = recorded.at(1.3);
  for (std::size_t i = 0; i < later.size(); ++i) EXPECT_NEAR(later[i], first[i], kExact);
}

}  // namespace edit_test
}  // namespace simuli

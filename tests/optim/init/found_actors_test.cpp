// Tests moving objects found by a training, with and without a label.
#include <algorithm>
#include <gtest/gtest.h>
#include <utility>

#include "optim/train/training.hpp"
#include "tests/optim/init/street_with_car.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

using Eigen::Vector3d;

class ATrainingsActors : public test::StreetWithCar {};

TEST_F(ATrainingsActors, TrainingFindsTheCarOfALogWithoutLabels) {
  Log bare = log_;
  bare.actors.clear();
  TrainingOptions options;
  options.init = small(true);
  options.frames.image_scale = 1.0;
  options.train.iterations = 0;
  Training training(test::device(), bare, options);
  training.prepare();
  const Scene scene = training.scene();
  ASSERT_EQ(scene.actors.size(), 1U);
  EXPECT_EQ(training.report().found.actors, 1U);
  EXPECT_EQ(scene.actors[0].name, "moving_0");
  for (const KeyPose& key : scene.actors[0].track) {
    const Vector3d apart = key.corrected().translation - log_.actors[0].at(key.time_s).translation;
    EXPECT_LT(apart.norm(), 0.4) << key.time_s;
  }
  // Sweep 9 is held out, but its time is part of the track.
  EXPECT_TRUE(scene.actors[0].is_there(0.95));
  EXPECT_GT(std::count(scene.lidar.actor.begin(), scene.lidar.actor.end(), 1U), 50);
  options.find_actors = false;
  Training blind(test::device(), bare, options);
  blind.prepare();
  EXPECT_TRUE(blind.scene().actors.empty());
  EXPECT_EQ(blind.report().found.sweeps, 0U);
}

TEST_F(ATrainingsActors, TrainingMendsLabelsThatCannotBe) {
  Log off = log_;
  for (const std::size_t k : {3U, 4U}) {
    Eigen::Quaterniond& rotation = off.actors[0].track[k].world_from_actor.rotation;
    rotation = rotation * Eigen::Quaterniond(0.0, 0.0, 0.0, 1.0);
  }
  Actor ego = log_.actors[0];
  ego.name = "ego";
  for (KeyPose& key : ego.track) {
    key.world_from_actor = log_.world_from_rig.at(key.time_s);
    key.world_from_actor.translation.z() += 0.8;
  }
  off.actors.push_back(ego);
  for (KeyPose& key : ego.track) key.world_from_actor.translation += Vector3d(30.0, 12.0, 1.2);
  ego.name = "wide";
  ego.size_m = {60.0, 20.0, 4.0};
  off.actors.push_back(ego);
  TrainingOptions options;
  options.init = small(true);
  options.frames.image_scale = 1.0;
  options.train.iterations = 0;
  const auto start_of = [&](const Log& log, std::size_t said) {
    Training training(test::device(), log, options);
    training.prepare();
    EXPECT_EQ(training.report().labels.size(), said);
    return training.scene();
  };
  const Scene right = start_of(log_, 0), mended = start_of(off, 3);
  ASSERT_EQ(mended.actors.size(), 1U);
  EXPECT_EQ(mended.lidar.actor, right.lidar.actor);
  EXPECT_EQ(mended.camera.size(), right.camera.size());
}

TEST_F(ATrainingsActors, TrainingGoesOnWhereALabelEnds) {
  TrainingOptions options;
  options.init = small(true);
  options.frames.image_scale = 1.0;
  const auto prepared = [&](const Log& log) {
    Training training(test::device(), log, options);
    training.prepare();
    return std::pair{training.report().found, training.scene().actors};
  };
  const auto [none, whole] = prepared(log_);  // the label covers the complete log
  EXPECT_EQ(none.actors, 1U);
  EXPECT_EQ(none.added + none.continued, 0U);
  ASSERT_EQ(whole.size(), 1U);
  EXPECT_EQ(whole[0].track.size(), log_.actors[0].track.size());

  Log cut = log_;
  std::vector<KeyPose>& track = cut.actors[0].track;
  while (track.size() > 1 && track.back().time_s > 0.55) track.pop_back();
  const auto [report, actors] = prepared(cut);
  EXPECT_EQ(report.added, 0U);
  EXPECT_EQ(report.continued, 1U);
  ASSERT_EQ(actors.size(), 1U);
  EXPECT_EQ(actors[0].name, "car");
  for (const double time_s : {0.65, 0.75, 0.95}) {
    EXPECT_TRUE(actors[0].is_there(time_s)) << time_s;
    EXPECT_LT((actors[0].at(time_s).translation - log_.actors[0].at(time_s).translation).norm(), 0.2)
        << time_s;
  }
}

}  // namespace
}  // namespace simuli

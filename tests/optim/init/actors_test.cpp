// Tests actors in initialisation, training and evaluation, on a small street with a moving car.
#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <utility>

#include "host/core/base/interruption.hpp"
#include "io/synth/street.hpp"
#include "optim/eval/evaluation.hpp"
#include "optim/init/actor_tracks.hpp"
#include "optim/init/initialize.hpp"
#include "optim/init/initialize_actors.hpp"
#include "optim/actors/actor_poses.hpp"
#include "optim/train/trainer.hpp"
#include "optim/train/training.hpp"
#include "tests/optim/init/street_with_car.hpp"
#include "tests/optim/small_street.hpp"
#include "tests/support/device.hpp"
#include "tests/support/scenes.hpp"

namespace simuli {
namespace {

using Eigen::Vector3d;

using test::StreetWithCar;

TEST_F(StreetWithCar, ParticlesOfTheCarAreInItsFrame) {
  const SceneInit start = initialize_scene(log_, kFullSize, small(true));
  ASSERT_EQ(start.scene.actors.size(), 1U);
  EXPECT_GT(start.report.actor_points, 300U);
  const Vector3d half = 0.5 * start.scene.actors[0].size_m + Vector3d::Constant(0.1 + 1e-6);
  for (const GaussianSet* set : {&start.scene.camera, &start.scene.lidar}) {
    ASSERT_EQ(set->actor.size(), static_cast<std::size_t>(set->size()));
    std::size_t of_car = 0;
    for (Eigen::Index i = 0; i < set->size(); ++i) {
      if (set->actor[static_cast<std::size_t>(i)] == 0) continue;
      ++of_car;
      ASSERT_TRUE((set->mean().row(i).transpose().cast<double>().array().abs() <= half.array()).all());
    }
    EXPECT_GT(of_car, 100U);
  }
  // The background has only road points at the middle position of the car.
  const Pose world_from_car = start.scene.actors[0].at(0.5);
  const GaussianSet& lidar = start.scene.lidar;
  for (Eigen::Index i = 0; i < lidar.size(); ++i) {
    if (lidar.actor[static_cast<std::size_t>(i)] != 0) continue;
    const Vector3d p = world_from_car.inverse() *
                       Vector3d(lidar.mean().row(i).transpose().cast<double>() + start.scene.origin);
    const double above_road = p.z() + 0.5 * start.scene.actors[0].size_m.z();
    const bool inside =
        std::abs(p.x()) < half.x() && std::abs(p.y()) < half.y() && above_road > 0.11 && p.z() < 0.5;
    EXPECT_FALSE(inside) << p.transpose();
  }
  EXPECT_TRUE(initialize_scene(log_, kFullSize, small(false)).scene.actors.empty());
}

TEST_F(StreetWithCar, PicturesFillTheGlassThatNoLaserReturnsFrom) {
  const Scene scene = initialize_scene(log_, kFullSize, small(true)).scene;
  const auto of_car = [](const GaussianSet& set) {
    std::vector<Vector3d> out;
    for (Eigen::Index i = 0; i < set.size(); ++i) {
      if (set.actor[static_cast<std::size_t>(i)] == 1)
        out.emplace_back(set.mean().row(i).transpose().cast<double>());
    }
    return out;
  };
  // Points of the body far from any return: the windows.
  const std::vector<Vector3d> returns = of_car(scene.lidar);
  std::size_t alone = 0;
  for (const Vector3d& p : of_car(scene.camera)) {
    const bool near =
        std::any_of(returns.begin(), returns.end(), [&](const Vector3d& r) { return (r - p).norm() < 0.12; });
    if (near) continue;
    ++alone;
    EXPECT_TRUE((p.array().abs() <= 0.5 * scene.actors[0].size_m.array() + 1e-5).all()) << p.transpose();
  }
  EXPECT_GT(alone, 10U);
  // Pixels of the car create no background along its track.
  for (Eigen::Index i = 0; i < scene.camera.size(); ++i) {
    if (scene.camera.actor[static_cast<std::size_t>(i)] != 0) continue;
    const Vector3d p = scene.camera.mean().row(i).transpose().cast<double>() + scene.origin;
    EXPECT_FALSE(p.x() > 15.0 && p.x() < 17.0 && std::abs(p.y() - 1.75) < 0.7 && p.z() > 0.1 && p.z() < 1.4)
        << p.transpose();
  }
}

TEST(ActorPoints, HideWhatIsBehindTheirBoxes) {
  Actor actor;
  actor.name = "car";
  actor.size_m = {4.0, 2.0, 1.5};
  actor.track = {{0.0, {Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * M_PI, Vector3d::UnitZ())), {10, 0, 0}}}};
  ActorPoints points({actor}, {.margin_m = 0.0}, Vector3d::Zero());
  VoxelGrid none(0.1);
  points.finish(none);
  PointSet background;
  background.position.resize(3, 6);
  // Ahead, behind, above, beside, behind the camera; and inside, where ground may be.
  background.position << 8, 15, 15, 15, -15, 10, 0, 0, 0, 6, 0, 0, 0, 0, 4, 0, 0, 0;
  background.intensity.assign(6, 0.0F);
  // A picture ahead, and one to the side that contains neither the car nor the points behind it.
  const Camera camera{"", 64, 64, 32.0, 32.0, 32.0, 32.0};
  const auto view = [&camera](const Vector3d& forward) {
    Eigen::Matrix3d axes;
    axes << forward.cross(Vector3d::UnitZ()), -Vector3d::UnitZ(), forward;
    const Pose at{Eigen::Quaterniond(axes), Vector3d::Zero()};
    return ImageView(camera, at, at);
  };
  const PointSet seen = points.placed(background, 0.0, view(Vector3d::UnitX()));
  for (Eigen::Index i = 0; i < 6; ++i) EXPECT_EQ(std::isnan(seen.position(0, i)), i == 1) << i;
  EXPECT_TRUE(points.placed(background, 1.0, view(Vector3d::UnitX())).position.allFinite());
  EXPECT_TRUE(points.placed(background, 0.0, view(Vector3d::UnitY())).position.allFinite());
}

TEST(ActorPoints, TakeReturnsWhereTheyAreMeanwhile) {
  // Around a corner: 10 m ahead, then 10 m to the left.
  Actor actor;
  actor.name = "car";
  actor.size_m = {4.0, 2.0, 1.5};
  const Eigen::Quaterniond ahead = Eigen::Quaterniond::Identity();
  actor.track = {{1.0, {ahead, {0, 0, 0}}}, {2.0, {ahead, {10, 0, 0}}}, {3.0, {ahead, {10, 10, 0}}}};
  ActorPoints points({actor}, {}, Vector3d::Zero());
  EXPECT_TRUE(points.places(0.0, 0.8).empty());
  EXPECT_TRUE(points.places(3.2, 4.0).empty());
  for (const double from_s : {0.5, 1.2, 1.9, 2.05}) {
    const std::vector<ActorPoints::ActorBall> places = points.places(from_s, from_s + 1.0);
    ASSERT_EQ(places.size(), 1U);
    for (double time_s = std::max(from_s, 0.95); time_s < std::min(from_s + 1.0, 3.05); time_s += 0.05) {
      const Vector3d middle = actor.at(time_s).translation;
      for (const double x : {-2.05, 0.0, 2.05}) {
        for (const double y : {-1.05, 1.05}) {
          EXPECT_TRUE(points.add(middle + Vector3d(x, y, 0.8), time_s, 0.5, places)) << time_s;
        }
      }
      EXPECT_FALSE(points.add(middle + Vector3d(2.2, 0.0, 0.0), time_s, 0.5, places)) << time_s;
    }
  }
}

TEST_F(StreetWithCar, TrainingWithActorsIsBetterWhereTheCarIs) {
  const Device& device = test::device();
  EvalReport reports[2];
  for (const bool actors : {false, true}) {
    TrainingOptions options;
    options.train.iterations = 60;
    options.frames.image_scale = 1.0;
    Trainer trainer(device, log_, initialize_scene(log_, kFullSize, small(actors)).scene, options);
    (void)trainer.run();
    const Scene scene = trainer.scene();
    if (actors) {
      const Vector3d half =
          0.5 * scene.actors[0].size_m + Vector3d::Constant(options.init.actor_margin_m + 1e-5);
      for (Eigen::Index i = 0; i < scene.camera.size(); ++i) {
        if (scene.camera.actor[static_cast<std::size_t>(i)] == 0) continue;
        const Vector3d p = scene.camera.mean().row(i).transpose().cast<double>();
        ASSERT_TRUE((p.array().abs() <= half.array()).all()) << p.transpose();
      }
    }
    reports[actors ? 1 : 0] = test::compare(log_, scene, {.image_scale = 1.0, .timed_renders = 1});
  }
  EXPECT_GT(reports[0].actor_pixels, 50U);
  EXPECT_EQ(reports[0].actor_pixels, reports[1].actor_pixels);
  EXPECT_GT(reports[1].actor_psnr_db, reports[0].actor_psnr_db + 3.0);
  EXPECT_LT(reports[1].actor_distance_median_m, 0.05);
}

TEST_F(StreetWithCar, TracksStayAsRecordedUnlessTheyAreLearned) {
  const Device& device = test::device();
  TrainingOptions options;
  options.train.iterations = 4;
  options.frames.image_scale = 1.0;
  InitOptions init = small(true);
  init.register_tracks = false;
  Trainer kept(device, log_, initialize_scene(log_, kFullSize, init).scene, options);
  (void)kept.run();
  const Scene recorded = kept.scene();
  ASSERT_FALSE(recorded.actors[0].track.empty());
  for (const KeyPose& key : recorded.actors[0].track) EXPECT_TRUE(key.shift_m.isZero(0.0));
  options.train.actor_poses = {.learn = true, .shift_m = 0.01};
  Trainer learned(device, log_, initialize_scene(log_, kFullSize, init).scene, options);
  Trainer again(device, log_, initialize_scene(log_, kFullSize, init).scene, options);
  (void)learned.run();
  (void)again.run();
  const std::vector<KeyPose> track = learned.scene().actors[0].track, same = again.scene().actors[0].track;
  ASSERT_EQ(track.size(), same.size());
  double moved = 0.0;
  for (std::size_t k = 0; k < track.size(); ++k) {
    moved += track[k].shift_m.norm();
    EXPECT_EQ(track[k].shift_m, same[k].shift_m);
  }
  EXPECT_GT(moved, 0.01);
}

TEST_F(StreetWithCar, DensifiedSetsStayWithTheirActorsAndResume) {
  const Device& device = test::device();
  TrainingOptions options;
  options.train.iterations = 24;
  options.frames.image_scale = 1.0;
  options.train.lidar_every = 2;
  options.train.densify.epochs = 0.6;
  options.train.anchor.weight = 0.01;
  options.train.actor_poses = {.learn = true, .shift_m = 0.01};
  Scene start = initialize_scene(log_, kFullSize, small(true)).scene;
  for (GaussianSet* set : {&start.camera, &start.lidar}) {
    for (Eigen::Index i = 0; i < set->size(); i += 9) set->opacity_logit()(i) = -7.0F;  // dead
  }
  Trainer whole(device, log_, start, options);
  for (int i = 0; i < 13; ++i) whole.step();
  whole.save(folder_ / "densified.checkpoint", "");
  const TrainReport report = whole.run();
  EXPECT_GT(report.relocated, static_cast<std::uint64_t>(start.camera.size() / 10));
  EXPECT_GT(report.grown, 100U);
  const Scene scene = whole.scene();
  const Vector3d half = 0.5 * scene.actors[0].size_m + Vector3d::Constant(options.init.actor_margin_m + 1e-5);
  for (const GaussianSet* set : {&scene.camera, &scene.lidar}) {
    ASSERT_EQ(set->actor.size(), static_cast<std::size_t>(set->size()));
    const auto count = std::count(set->actor.begin(), set->actor.end(), 1U);
    EXPECT_GT(count, 100);
    EXPECT_LT(count, set->size() / 2);
    for (Eigen::Index i = 0; i < set->size(); ++i) {
      if (set->actor[static_cast<std::size_t>(i)] == 0) continue;
      const Vector3d p = set->mean().row(i).transpose().cast<double>();
      ASSERT_TRUE((p.array().abs() <= half.array()).all()) << p.transpose();
    }
  }
  Trainer resumed(device, log_, start, options);
  resumed.step();  // earlier steps have no effect
  resumed.resume(folder_ / "densified.checkpoint", "");
  (void)resumed.run();
  const Scene again = resumed.scene();
  EXPECT_EQ(again.camera.actor, scene.camera.actor);
  EXPECT_EQ(again.lidar.actor, scene.lidar.actor);
  EXPECT_EQ(again.camera.params, scene.camera.params);
  EXPECT_EQ(again.lidar.params, scene.lidar.params);
  for (std::size_t k = 0; k < scene.actors[0].track.size(); ++k) {
    EXPECT_EQ(again.actors[0].track[k].shift_m, scene.actors[0].track[k].shift_m);
    EXPECT_EQ(again.actors[0].track[k].turn_rad, scene.actors[0].track[k].turn_rad);
  }
}

TEST_F(StreetWithCar, WhatIsNotANumberLeavesTheOthersWithTheirActor) {
  Scene start = initialize_scene(log_, kFullSize, small(true)).scene;
  const auto first_of_car = std::find(start.camera.actor.begin(), start.camera.actor.end(), 1U);
  start.camera.mean()(first_of_car - start.camera.actor.begin(), 0) = std::nanf("");
  TrainingOptions options;
  options.train.iterations = 1;
  options.frames.image_scale = 1.0;
  const Scene scene = Trainer(test::device(), log_, start, options).scene();
  ASSERT_EQ(scene.camera.size(), start.camera.size() - 1);
  start.camera.actor.erase(first_of_car);
  EXPECT_EQ(scene.camera.actor, start.camera.actor);
}

TEST(ActorTracks, AreWonBackFromReturns) {
  // A box with a lower front passes; returns from three faces, at times between the key poses.
  Actor truth;
  truth.name = "car";
  truth.size_m = {4.0, 1.8, 1.5};
  for (int k = 0; k < 20; ++k) {
    const double s = 0.1 * k;
    truth.track.push_back({s,
                           {Eigen::Quaterniond(Eigen::AngleAxisd(0.1 * s, Vector3d::UnitZ())),
                            {5.0 + 6.0 * s, 2.0 + 0.3 * s * s, 0.75}}});
  }
  test::Random random(3);
  std::vector<ActorReturn> returns;
  for (int i = 0; i < 6000; ++i) {
    const double time_s = 0.02 + 0.1 * (i % 19) + random.uniform(0.0, 0.004);
    Vector3d p = random.in_box({-2.0, -0.9, -0.75}, {2.0, 0.9, 0.75});
    if (i % 3 == 0) p.x() = -2.0;
    if (i % 3 == 1) p.y() = -0.9;
    if (i % 3 == 2) p.z() = p.x() > 0.5 ? 0.1 : 0.75;
    const Vector3d noise(random.normal(), random.normal(), random.normal());
    returns.push_back({time_s, truth.at(time_s) * p + 0.01 * noise});
  }
  Actor noisy = truth;
  for (KeyPose& key : noisy.track) {
    key.world_from_actor.translation += 0.2 * Vector3d(random.normal(), random.normal(), 0.0);
    key.world_from_actor.rotation =
        Eigen::AngleAxisd(2.0 * M_PI / 180.0 * random.normal(), Vector3d::UnitZ()) *
        key.world_from_actor.rotation;
  }
  // The spread around the mean error, which belongs to the actor's frame.
  const auto spread = [&](const Actor& actor) {
    const auto off = [&](std::size_t k) {
      return truth.track[k].corrected().inverse() * actor.track[k].corrected();
    };
    Vector3d shift = Vector3d::Zero();
    double square = 0.0, turn = 0.0;
    const auto count = static_cast<double>(actor.track.size());
    for (std::size_t k = 0; k < actor.track.size(); ++k) shift += off(k).translation / count;
    for (std::size_t k = 0; k < actor.track.size(); ++k) {
      square += (off(k).translation - shift).squaredNorm() / count;
      turn += Eigen::AngleAxisd(off(k).rotation * off(0).rotation.conjugate()).angle() / count;
    }
    return std::pair(std::sqrt(square), turn);
  };
  Actor found = noisy;
  int looks = 0;
  const std::function<void()> look = [&] { ++looks; };
  const Interruption interruption(look);
  register_track(found, returns);
  EXPECT_GT(looks, 1);
  EXPECT_GT(spread(noisy).first, 0.2);
  EXPECT_LT(spread(found).first, 0.15 * spread(noisy).first) << spread(found).first;
  EXPECT_LT(spread(found).second, 0.3 * spread(noisy).second) << spread(found).second;
  // Recorded poses and a track without observations are unchanged.
  EXPECT_EQ(found.track[3].world_from_actor.translation, noisy.track[3].world_from_actor.translation);
  Actor unseen = noisy;
  register_track(unseen, {});
  EXPECT_TRUE(unseen.track[5].shift_m.isZero(0.0));
}

TEST(ActorPoses, WalkDownASlopeToTheTruth) {
  Actor actor;
  actor.name = "car";
  for (int k = 0; k < 4; ++k)
    actor.track.push_back({0.1 * k, {Eigen::Quaterniond::Identity(), {1.0 * k, 0, 0}}});
  actor.track[1].shift_m = {0.2, -0.1, 0.0};
  actor.track[2].turn_rad = {0.0, 0.0, 0.05};
  std::vector<Actor> actors{actor};
  Actor truth = actor;
  for (KeyPose& key : truth.track) key.shift_m = key.turn_rad = Vector3d::Zero();
  ActorPoses poses({.learn = true, .shift_m = 0.01, .turn_rad = 0.003, .final_share = 0.01});
  constexpr int kSteps = 600;
  for (int i = 0; i < kSteps; ++i) {
    const double start_s = 0.05 * (i % 6), end_s = start_s + 0.05;
    // The loss is half the squared distance of each pose from the truth.
    ActorPoseGradient g;
    const auto error = [&](double time_s, Vector3d& shift, Vector3d& turn) {
      const Pose found = actors[0].at(time_s), expected = truth.at(time_s);
      shift = found.translation - expected.translation;
      const Eigen::AngleAxisd apart(found.rotation * expected.rotation.conjugate());
      turn = apart.angle() * apart.axis();
    };
    error(start_s, g.shift_start, g.revolution_start);
    error(end_s, g.shift_end, g.turn_end);
    poses.step(actors, {g}, start_s, end_s, static_cast<double>(i) / kSteps);
  }
  for (const KeyPose& key : actors[0].track) {
    EXPECT_LT(key.shift_m.norm(), 5e-3);
    EXPECT_LT(key.turn_rad.norm(), 2e-3);
  }
}

}  // namespace
}  // namespace simuli

#include "optim/train/trainer.hpp"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <vector>

#include "host/core/base/error.hpp"
#include "host/core/scene/particle_order.hpp"
#include "tests/optim/small_street.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

class TrainerTest : public test::SmallStreet {
 protected:
  static TrainingOptions options(int iterations) {
    TrainingOptions o;
    o.train.iterations = iterations;
    o.frames.image_scale = 1.0;
    o.train.lidar_every = 1;
    return o;
  }
  static Scene train(const TrainingOptions& o, TrainReport* report = nullptr) {
    Trainer trainer(test::device(), log_, initial_scene(), o);
    const TrainReport r = trainer.run();
    if (report != nullptr) *report = r;
    return trainer.scene();
  }
};

TEST_F(TrainerTest, SameSeedGivesTheSameBits) {
  const Scene a = train(options(20));
  const Scene b = train(options(20));
  EXPECT_TRUE((a.camera.params.array() == b.camera.params.array()).all());
  EXPECT_TRUE((a.lidar.params.array() == b.lidar.params.array()).all());

  TrainingOptions other = options(20);
  other.frames.seed = 2;  // another order of frames
  EXPECT_FALSE((a.camera.params.array() == train(other).camera.params.array()).all());
}

TEST_F(TrainerTest, FramesReloadedFromDiskGiveTheSameBits) {
  TrainingOptions no_cache = options(10);
  no_cache.train.cache_bytes = 0;
  const Scene a = train(options(10));
  const Scene b = train(no_cache);
  EXPECT_TRUE((a.camera.params.array() == b.camera.params.array()).all());
  EXPECT_TRUE((a.lidar.params.array() == b.lidar.params.array()).all());
}

TEST_F(TrainerTest, TrainingRecoversFromWrongColoursAndRanges) {
  Scene scene = initial_scene();
  scene.camera.sh(0).setZero();  // grey
  scene.lidar.mean().col(2).array() += 0.1F;
  Trainer trainer(test::device(), log_, scene, options(120));
  trainer.step();
  const TrainStatus first = trainer.status();
  const TrainReport report = trainer.run();
  EXPECT_EQ(report.last.iteration, 120);
  EXPECT_GT(report.last.psnr_db, first.psnr_db + 3.0) << first.psnr_db;  // half the squared error
  EXPECT_LT(report.last.distance_m, 0.7 * first.distance_m) << first.distance_m;
  EXPECT_GT(report.last.drop_accuracy, 0.8);
  EXPECT_EQ(report.rejected_gradients, 0U);
  EXPECT_EQ(report.images, 5U);
  EXPECT_EQ(report.sweeps, 5U);
  EXPECT_FALSE(report.stopped_early);
}

TEST_F(TrainerTest, AScenesBestOrderIsTheOneItWasTrainedIn) {
  const auto options_in = [](Order order, int iterations) {
    TrainingOptions o = options(iterations);
    o.train.render.order = order;
    return o;
  };
  // Error of each picture before its step; the same pictures for both scenes.
  const auto psnr_db = [&](const Scene& scene, Order order) {
    constexpr int kPictures = 5;
    Trainer trainer(test::device(), log_, scene, options_in(order, kPictures));
    double sum = 0.0;
    for (int k = 0; k < kPictures; ++k) {
      trainer.step();
      sum += trainer.status().psnr_db;
    }
    return sum / kPictures;
  };
  const Scene by_range = train(options_in(Order::kRange, 150));
  const Scene by_ray = train(options_in(Order::kWindow, 150));
  EXPECT_GT(psnr_db(by_ray, Order::kWindow), psnr_db(by_range, Order::kWindow) + 0.1);
  EXPECT_GT(psnr_db(by_range, Order::kRange), psnr_db(by_ray, Order::kRange) + 0.1);
  const Scene once = train(options_in(Order::kWindow, 10)), again = train(options_in(Order::kWindow, 10));
  EXPECT_TRUE((once.camera.params.array() == again.camera.params.array()).all());
}

TEST_F(TrainerTest, DropFunctionsAreLearnedByNameAndStored) {
  TrainingOptions o = options(9);
  o.train.ray_drop.apart = 2;  // of five sweeps, the second and fourth only train the drop function
  const Scene scene = train(o);
  ASSERT_EQ(scene.ray_drop.size(), 1U);
  EXPECT_EQ(scene.ray_drop[0].lidar, name_of(log_.lidars[0].model));
  EXPECT_NE(scene.ray_drop[0].parameters, RayDrop::start());
  EXPECT_EQ(train(o).ray_drop, scene.ray_drop);
  Scene start = initial_scene();
  start.ray_drop = scene.ray_drop;  // continues with these parameters
  o.train.iterations = 0;
  EXPECT_EQ(Trainer(test::device(), log_, start, o).scene().ray_drop, scene.ray_drop);
  o.train.iterations = 9;
  o.train.ray_drop.rate = 0.0;
  EXPECT_TRUE(train(o).ray_drop.empty());
}

TEST_F(TrainerTest, ASweepTeachesTheDropFunctionOrParticles) {
  TrainingOptions o = options(1);
  o.train.ray_drop.apart = 2;
  const TrainedDrop drop(log_, initial_scene(), o);
  constexpr LidarLossScale kScale{0.5, 0.1, 0.05, 0.0};
  const auto share = [&](std::size_t sweep) { return drop.share(sweep, kScale); };
  EXPECT_EQ(share(0).entropy, 0.05);
  EXPECT_EQ(share(0).function_entropy, 0.0);
  EXPECT_EQ(share(1).entropy, 0.0);
  EXPECT_EQ(share(1).function_entropy, 0.05);
  EXPECT_EQ(share(1).distance, 0.5);
  o.train.ray_drop.apart = 3;  // five sweeps are too few
  EXPECT_EQ(TrainedDrop(log_, initial_scene(), o).share(1, kScale).entropy, 0.05);
  EXPECT_EQ(TrainedDrop(log_, initial_scene(), o).share(1, kScale).function_entropy, 0.05);
}

TEST_F(TrainerTest, HeldOutFramesAreNeverRead) {
  Log log = log_;
  log.images[4].file = "images/none.png";
  log.sweeps[4].file = "sweeps/none.exr";
  TrainingOptions o = options(12);  // more than two epochs
  EXPECT_NO_THROW((void)Trainer(test::device(), log, initial_scene(), o).run());
  o.frames.held_out_every = 0;
  EXPECT_THROW((void)Trainer(test::device(), log, initial_scene(), o).run(), Error);
}

TEST_F(TrainerTest, TimeLimitStopsEarlyAndSaysSo) {
  TrainingOptions o = options(1'000'000);
  o.train.max_seconds = 1e-9;
  TrainReport report;
  const Scene scene = train(o, &report);
  EXPECT_TRUE(report.stopped_early);
  EXPECT_LT(report.last.iteration, 10);
  EXPECT_EQ(scene.camera.size(), initial_scene().camera.size());
}

TEST_F(TrainerTest, SweepsTakeTheirTurns) {
  TrainingOptions o = options(2);
  o.train.lidar_every = 2;
  Trainer trainer(test::device(), log_, initial_scene(), o);
  trainer.step();
  const Eigen::MatrixXf first = trainer.scene().lidar.params;
  trainer.step();
  EXPECT_TRUE((trainer.scene().lidar.params.array() == first.array()).all());
  EXPECT_FALSE((initial_scene().lidar.params.array() == first.array()).all());
}

TEST_F(TrainerTest, ASecondLidarTakesNoTurnsFromTheFirst) {
  Log log = log_;
  log.lidars.push_back(log.lidars.front());
  std::visit([](auto& model) { model.name = "second"; }, log.lidars.back().model);
  TrainingOptions o = options(2);
  o.train.lidar_every = 3;
  EXPECT_EQ(iterations_a_sweep(o, log), 3) << "no sweep of the second";
  for (SweepFrame sweep : log_.sweeps) {
    sweep.lidar = "second";
    log.sweeps.push_back(sweep);
  }
  EXPECT_EQ(iterations_a_sweep(o, log), 2);
  o.train.lidar_every = 2;
  EXPECT_EQ(iterations_a_sweep(o, log), 1);
  Trainer trainer(test::device(), log, initial_scene(), o);
  trainer.step();
  const Eigen::MatrixXf first = trainer.scene().lidar.params;
  trainer.step();
  EXPECT_FALSE((trainer.scene().lidar.params.array() == first.array()).all());
  o.frames.held_out_sensors = {"second"};
  EXPECT_EQ(iterations_a_sweep(o, log), 2);
}

TEST_F(TrainerTest, ByDefaultTheCameraSetAloneGrowsAndNotForEver) {
  TrainingOptions o = options(60);
  o.train.densify.growth = 0.5;
  const Scene start = initial_scene();
  Trainer trainer(test::device(), log_, start, o);
  trainer.run();
  EXPECT_EQ(trainer.scene().lidar.size(), start.lidar.size());
  EXPECT_EQ(trainer.scene().camera.size(), 2 * start.camera.size());  // densify.most
}

/// Of which there are five.
TEST_F(TrainerTest, GrowthCountsUsesOfPicturesForAnyShards) {
  for (const auto& [epochs, shards, first] :
       {std::tuple{1.0, 1, 10}, {2.0, 1, 20}, {1.0, 2, 6}, {0.2, 5, 2}}) {
    TrainingOptions o = options(60);
    o.train.densify.epochs = epochs;
    o.train.shards.count = shards;
    const Scene start = initial_scene();
    Trainer trainer(test::device(), log_, start, o);
    for (int i = 1; i < first; ++i) trainer.step();
    EXPECT_EQ(trainer.scene().camera.size(), start.camera.size()) << epochs << " " << shards;
    trainer.step();
    EXPECT_GT(trainer.scene().camera.size(), start.camera.size()) << epochs << " " << shards;
  }
}

TEST_F(TrainerTest, PruningTakesOutWhatNoSweepSeesAndNothingElse) {
  Scene start = initial_scene();
  const Eigen::Index buried = start.lidar.size() / 7;
  for (Eigen::Index i = 0; i < buried; ++i) start.lidar.mean().row(7 * i).z() = -50.0F;
  TrainingOptions o = options(2);
  o.frames.held_out_every = 0;  // all sweeps are compared below
  o.train.lidar = {.mean_m = 1e-9,
                   .mean_final_m = 1e-9,
                   .log_scale = 0.0,
                   .rotation = 0.0,
                   .opacity = 0.0,
                   .sh = 0.0,
                   .sh_rest = 0.0};
  o.train.prune = {.weight = 1e-6, .first = 0, .times = 1, .last_share = 0.5};
  Trainer trainer(test::device(), log_, start, o);
  trainer.step();
  EXPECT_EQ(trainer.scene().lidar.size(), start.lidar.size());  // not in this iteration
  const TrainReport report = trainer.run();
  const Scene pruned = trainer.scene();
  EXPECT_EQ(report.pruned, static_cast<std::uint64_t>(start.lidar.size() - pruned.lidar.size()));
  EXPECT_GE(report.pruned, static_cast<std::uint64_t>(buried));
  EXPECT_LT(report.pruned, static_cast<std::uint64_t>(start.lidar.size() / 2));
  EXPECT_EQ(pruned.camera.size(), start.camera.size());
  // Remaining particles are unchanged.
  std::vector<bool> found(static_cast<std::size_t>(start.lidar.size()), false);
  Eigen::Index at = 0;  // likely index of the next one
  for (Eigen::Index i = 0; i < pruned.lidar.size(); ++i) {
    EXPECT_GT(pruned.lidar.mean()(i, 2), -40.0F);
    const auto is_it = [&](Eigen::Index j) {
      return !found[static_cast<std::size_t>(j)] &&
             (start.lidar.mean().row(j) - pruned.lidar.mean().row(i)).norm() < 1e-5F;
    };
    Eigen::Index tried = 0;
    while (tried < start.lidar.size() && !is_it((at + tried) % start.lidar.size())) ++tried;
    ASSERT_LT(tried, start.lidar.size()) << i;
    at = (at + tried) % start.lidar.size();
    found[static_cast<std::size_t>(at)] = true;
  }
  // Training sweeps have equal results with the same drop function.
  start.ray_drop = pruned.ray_drop;
  const EvalOptions trained{.image_scale = 1.0, .held_out_every = 0, .timed_renders = 1};
  const EvalReport before = test::compare(log_, start, trained), after = test::compare(log_, pruned, trained);
  EXPECT_NEAR(after.lidar.distance_median_m, before.lidar.distance_median_m, 1e-5);
  EXPECT_NEAR(after.lidar.intensity_rmse, before.lidar.intensity_rmse, 1e-5);
  EXPECT_NEAR(after.lidar.chamfer_m, before.lidar.chamfer_m, 1e-5);
}

TEST_F(TrainerTest, DensificationGrowsToItsCapAndIsReproducible) {
  TrainingOptions o = options(60);
  o.train.densify.epochs = 2.0;
  o.train.densify.lidar = true;
  o.train.densify.growth = 0.05;
  Scene start = initial_scene();
  for (Eigen::Index i = 0; i < start.camera.size(); i += 20) start.camera.opacity_logit()(i) = -7.0F;  // dead
  const Eigen::Index count = start.camera.size() + start.lidar.size();
  // Capacity for two steps of 5 %.
  o.train.densify.cap = static_cast<std::size_t>(1.08 * static_cast<double>(count));
  const auto run = [&](TrainReport& report) {
    Trainer trainer(test::device(), log_, start, o);
    report = trainer.run();
    return trainer.scene();
  };
  TrainReport report;
  const Scene a = run(report);
  EXPECT_GE(report.relocated, static_cast<std::uint64_t>(start.camera.size() / 20));
  EXPECT_LE(static_cast<std::size_t>(a.camera.size() + a.lidar.size()), o.train.densify.cap);
  EXPECT_GT(static_cast<double>(a.camera.size() + a.lidar.size()), 1.07 * static_cast<double>(count));
  EXPECT_EQ(a.camera.size() + a.lidar.size(), count + static_cast<Eigen::Index>(report.grown));
  EXPECT_GT(a.camera.size(), start.camera.size());
  EXPECT_GT(a.lidar.size(), start.lidar.size());
  EXPECT_TRUE(a.camera.params.allFinite());
  EXPECT_TRUE(a.lidar.params.allFinite());
  EXPECT_EQ(report.unsound_particles, 0U);
  const Scene b = run(report);
  EXPECT_EQ(a.camera.params, b.camera.params);
  EXPECT_EQ(a.lidar.params, b.lidar.params);
}

TEST_F(TrainerTest, AnchorsHoldTheCameraSetNearTheLidarSet) {
  const auto anchor_distance = [&](double weight) {
    TrainingOptions o = options(60);
    o.train.anchor.weight = weight;
    TrainReport report;
    (void)train(o, &report);
    return report.anchor_m;
  };
  const double pulled = anchor_distance(10.0);
  const double hardly = anchor_distance(1e-9);  // computed, but too weak for an effect
  EXPECT_GT(pulled, 0.0);
  EXPECT_LT(pulled, 0.7 * hardly) << hardly;
  EXPECT_EQ(anchor_distance(0.0), 0.0);  // not computed
}

TEST_F(TrainerTest, SweepsHoldTheCameraSetWhereTheirReturnsAre) {
  // Median error in m of the camera set's distances along the sweeps' rays: few rays through a hole make the
  // mean of 100 iterations 0.12 to 0.3 m.
  const auto error_m = [&](double weight) {
    TrainingOptions o = options(100);
    o.train.depth = {.weight = weight, .every = 1};
    o.train.densify.epochs = 0.0;  // new particles are placed by picture errors, not by returns
    Scene scene = train(o);
    GaussianSet as_lidar(SetKind::kLidar, scene.camera.sh_degree, scene.camera.size());
    as_lidar.params.leftCols(kShRow) = scene.camera.params.leftCols(kShRow);
    scene.lidar = as_lidar;
    scene.ray_drop.clear();
    const EvalOptions trained{.image_scale = 1.0, .held_out_every = 0, .timed_renders = 1};
    return test::compare(log_, scene, trained).lidar.distance_median_m;
  };
  const double without = error_m(0.0);
  EXPECT_LT(error_m(1.0), 0.4 * without) << without;
}

TEST_F(TrainerTest, WhatIsNotANumberDoesNoHarmAndIsCounted) {
  Scene scene = initial_scene();
  const float kNotANumber = std::numeric_limits<float>::quiet_NaN();
  for (Eigen::Index i = 0; i < scene.camera.size(); i += 50) scene.camera.sh(0)(i, 1) = kNotANumber;
  for (Eigen::Index i = 1; i < scene.lidar.size(); i += 50) scene.lidar.mean()(i, 0) = kNotANumber;
  for (Eigen::Index i = 2; i < scene.lidar.size(); i += 50) scene.lidar.opacity_logit()(i) = kNotANumber;
  for (const bool relocate : {false, true}) {
    TrainingOptions o = options(30);
    o.train.densify.epochs = relocate ? 2.0 : 0.0;
    o.train.densify.lidar = true;
    o.train.densify.growth = 0.0;
    Trainer trainer(test::device(), log_, scene, o);
    const TrainReport report = trainer.run();
    EXPECT_EQ(report.last.iteration, 30);
    EXPECT_EQ(report.unsound_losses, 0U);
    EXPECT_TRUE(std::isfinite(report.last.psnr_db));
    EXPECT_TRUE(std::isfinite(report.last.distance_m));
    const Scene after = trainer.scene();
    EXPECT_TRUE(after.lidar.params.allFinite());
    EXPECT_TRUE(after.camera.params.allFinite());
    const auto lost = static_cast<std::uint64_t>(scene.camera.size() + scene.lidar.size() -
                                                 after.camera.size() - after.lidar.size());
    EXPECT_EQ(report.unsound_particles, lost);
    if (relocate) {
      EXPECT_EQ(lost, 0U);
    } else {
      EXPECT_GE(lost, static_cast<std::uint64_t>(scene.camera.size() / 50 + 2 * (scene.lidar.size() / 50)));
    }
  }
}

TEST_F(TrainerTest, SetsWithoutParticlesAreLeftAlone) {
  Scene scene = initial_scene();
  scene.camera = GaussianSet(SetKind::kCamera, 0, 0);
  Trainer trainer(test::device(), log_, scene, options(2));
  const TrainReport report = trainer.run();
  EXPECT_TRUE(std::isnan(report.last.psnr_db));
  EXPECT_TRUE(std::isfinite(report.last.distance_m));
  EXPECT_EQ(trainer.scene().camera.size(), 0);
}

TEST_F(TrainerTest, OptionsOutsideTheirRangeAreUsageErrors) {
  const double kNotANumber = std::numeric_limits<double>::quiet_NaN();
  const auto expect_refused = [](const std::function<void(TrainingOptions&)>& change) {
    TrainingOptions o = options(1);
    change(o);
    try {
      Trainer(test::device(), log_, Scene{}, o).step();
      ADD_FAILURE() << "accepted";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kUsage) << error.what();
    }
  };
  expect_refused([](TrainingOptions& o) { o.train.iterations = -1; });
  expect_refused([](TrainingOptions& o) { o.train.lidar_every = 0; });
  expect_refused([](TrainingOptions& o) { o.frames.held_out_every = 1; });
  expect_refused([](TrainingOptions& o) { o.frames.image_scale = 0.0; });
  expect_refused([&](TrainingOptions& o) { o.frames.image_scale = kNotANumber; });
  expect_refused([&](TrainingOptions& o) { o.train.max_seconds = kNotANumber; });
  expect_refused([&](TrainingOptions& o) { o.train.camera.sh = kNotANumber; });
  expect_refused([](TrainingOptions& o) { o.train.weights.drop = -1.0; });
  expect_refused([&](TrainingOptions& o) { o.train.anchor.weight = kNotANumber; });
  expect_refused([](TrainingOptions& o) { o.train.densify.epochs = -1.0; });
  expect_refused([](TrainingOptions& o) { o.train.densify.most = 0.5; });
}

TEST_F(TrainerTest, LogWithoutTrainingFramesIsAnInputError) {
  Log log = log_;
  log.images.clear();
  log.sweeps.clear();
  try {
    Trainer(test::device(), log, Scene{}, options(1)).step();
    ADD_FAILURE() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInput) << error.what();
  }
}

}  // namespace
}  // namespace simuli

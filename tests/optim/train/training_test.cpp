// Tests the complete training, from a log to a scene with its record.
#include "optim/train/training.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "host/device/render/options/quality.hpp"
#include "optim/data/sensor_learning.hpp"
#include "optim/eval/evaluation.hpp"
#include "optim/train/trainer.hpp"
#include "tests/host/expect_error.hpp"
#include "tests/optim/small_street.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

class TrainingTest : public test::SmallStreet {
 protected:
  static TrainingOptions options(int iterations) {
    TrainingOptions o;
    o.frames.image_scale = 1.0;
    o.init.voxel_m = 0.3;
    o.init.sweep_depth = false;
    o.train.iterations = iterations;
    o.train.lidar_every = 2;
    return o;
  }
  static void expect_same(const Scene& found, const Scene& expected) {
    EXPECT_EQ(found.camera.params, expected.camera.params);
    EXPECT_EQ(found.lidar.params, expected.lidar.params);
  }
};

TEST_F(TrainingTest, IsTheRecipeStepByStep) {
  const TrainingOptions o = options(12);
  Training training(test::device(), log_, o);
  training.run();
  const Log log = with_learned_sensors(log_, o.frames);
  SceneInit start = initialize_scene(log, o.frames, o.init);
  Trainer trainer(test::device(), log, std::move(start.scene), o);
  (void)trainer.run();
  expect_same(training.scene(), trainer.scene());
  EXPECT_EQ(training.report().init.voxels, start.report.voxels);
  EXPECT_EQ(training.report().train.last.iteration, 12);
}

/// During training they would be pruned: no ray intersects them.
TEST_F(TrainingTest, WallsAboveTheLaserJoinWhatWasTrained) {
  TrainingOptions o = options(4);
  o.init.voxel_m = 0.2;
  const GaussianSet above = initialize_scene(log_, o.frames, o.init).unmet;
  ASSERT_GT(above.size(), 0);
  Training training(test::device(), log_, o);
  training.run();
  EXPECT_EQ(training.report().init.unmet_points, static_cast<std::size_t>(above.size()));
  const Eigen::Index trained = training.scene().lidar.size();
  const Scene scene = training.result().scene;
  ASSERT_EQ(scene.lidar.size(), trained + above.size());
  EXPECT_EQ(scene.lidar.mean().bottomRows(above.size()), above.mean());
  o.init.lidar_walls_m = 0.0;
  Training without(test::device(), log_, o);
  without.run();
  EXPECT_EQ(without.result().scene.lidar.size(), trained);
}

TEST_F(TrainingTest, ADivergedOneIsNoScene) {
  TrainingOptions o = options(40);
  o.train.camera.sh = 100.0;
  Training diverged(test::device(), log_, o);
  expect_error(ErrorKind::kNumeric, "PSNR of the training pictures fell from", [&] { diverged.run(); });
}

TEST_F(TrainingTest, TheSceneSaysHowItWasMade) {
  TrainingOptions o = options(3);
  o.frames.seed = 0xffffffffffffffffU;
  o.train.densify.cap = 12345;
  Training training(test::device(), log_, o);
  training.run();
  SceneFile made = training.result();
  EXPECT_TRUE(made.training->labels_left_out.empty());
  made.training->labels_left_out = {"wide"};
  write_scene(folder_ / "made.scene", made);
  const SceneFile read = read_scene(folder_ / "made.scene");
  ASSERT_TRUE(read.training.has_value());
  const TrainingRecord& record = *read.training;
  EXPECT_EQ(record.log_name, log_.name);
  EXPECT_EQ(record.log_hash, log_hash(read_log(log_.folder)));
  EXPECT_EQ(record.frames.image_scale, 1.0);
  EXPECT_EQ(record.frames.held_out_every, 5);
  EXPECT_EQ(record.frames.seed, o.frames.seed);
  EXPECT_EQ(record.iterations, 3);
  EXPECT_EQ(record.planned_iterations, 3);
  EXPECT_EQ(record.quality, "balanced");
  EXPECT_NE(std::find(record.settings.begin(), record.settings.end(), "densify.cap=12345"),
            record.settings.end());
  EXPECT_EQ(record.settings, made.training->settings);
  EXPECT_EQ(record.labels_left_out, made.training->labels_left_out);
  EXPECT_EQ(record.device, test::device().info().label());
  EXPECT_EQ(record.driver, test::device().info().driver_version);
  EXPECT_FALSE(record.version.empty());
}

TEST_F(TrainingTest, TheSceneIsDrawnWithTheWidthOfPixelsThatItWasTrainedWith) {
  TrainingOptions o = options(2);
  for (const double requested : {kOfScene, 0.3}) {
    o.train.render.camera_filter_px2 = requested;
    Training training(test::device(), log_, o);
    training.run();
    EXPECT_EQ(training.result().scene.camera_filter_px2,
              requested == kOfScene ? kPixelVariance_px2 : requested);
  }
}

TEST_F(TrainingTest, AScenesOwnBundleIsNamed) {
  EXPECT_EQ(options(1).train.render.extent, Extent::kExact);  // like `simuli train`
  TrainingOptions o = options(0);
  o.train.render = training_options_of(Quality::kDraft);
  Training draft(test::device(), log_, o);
  draft.run();
  EXPECT_EQ(draft.result().training->quality, "draft");
  o.train.render.alpha_cut = 0.01;
  Training own(test::device(), log_, o);
  own.run();
  EXPECT_EQ(own.result().training->quality, "custom");
}

TEST_F(TrainingTest, CheckpointsGoOnWithTheSameBits) {
  const TrainingOptions o = options(20);
  Training whole(test::device(), log_, o);
  const std::filesystem::path file = folder_ / "a.checkpoint";
  std::vector<int> saved;
  whole.run(
      [&](const TrainStatus& status) {
        if (std::filesystem::exists(file)) {
          saved.push_back(status.iteration);
          std::filesystem::rename(file, folder_ / fmt::format("{}.checkpoint", status.iteration - 1));
        }
      },
      {file, 8});
  EXPECT_EQ(saved, (std::vector{9, 17}));
  EXPECT_TRUE(std::filesystem::exists(file));  // at the end
  for (const char* name : {"8", "16", "a"}) {
    Training resumed(test::device(), log_, o);
    resumed.resume(folder_ / (std::string(name) + ".checkpoint"));
    resumed.run();
    expect_same(resumed.scene(), whole.scene());
    EXPECT_EQ(resumed.result().training->iterations, 20);
  }
}

TEST_F(TrainingTest, ALongerTrainingGoesOnFromAFinishedOne) {
  const std::filesystem::path file = folder_ / "short.checkpoint";
  Training first(test::device(), log_, options(10));
  first.run({}, {file, 100});
  const auto longer = [&] {
    Training training(test::device(), log_, options(20));
    training.resume(file);
    EXPECT_EQ(training.status().iteration, 10);
    training.run();
    return training.result();
  };
  const SceneFile a = longer();
  expect_same(longer().scene, a.scene);  // reproducible
  EXPECT_EQ(a.training->iterations, 20);
  // The first half used the learning rates of the shorter training.
  Training whole(test::device(), log_, options(20));
  whole.run();
  const GaussianSet &other = whole.scene().camera, &one = a.scene.camera;
  EXPECT_FALSE(other.size() == one.size() && other.params == one.params);
  Training shorter(test::device(), log_, options(9));
  expect_error(ErrorKind::kInput, "iterations: found a training of 10, allowed of 9 or fewer", [&] {
    shorter.resume(file);
  });
}

TEST_F(TrainingTest, AnotherTrainingsCheckpointIsRefusedBeforeTheStart) {
  const std::filesystem::path file = folder_ / "one.checkpoint";
  Training one(test::device(), log_, options(2));
  one.run({}, {file, 100});
  const auto refused = [&](const Log& log, const TrainingOptions& o, const std::string& message) {
    Training other(test::device(), log, o);
    expect_error(ErrorKind::kInput, message, [&] {
      other.resume(file,
                   [](const std::string&, std::size_t, std::size_t) { ADD_FAILURE() << "a file was read"; });
    });
  };
  TrainingOptions o = options(2);
  o.frames.seed = 2;
  refused(log_, o, "settings: found seed=1, allowed seed=2");
  o = options(2);
  o.learn_sensors = false;
  refused(log_, o, "found sensors.learn=true, allowed sensors.learn=false");
  Log other = log_;
  other.sweeps.pop_back();
  refused(other, options(2), fmt::format("found log={} {}", log_.name, log_hash(log_)));
}

TEST_F(TrainingTest, LogsAreKnownByWhatTheySayAndNotByWhereTheyLie) {
  const std::filesystem::path copy = folder_ / "copy.log";
  std::filesystem::copy(log_.folder, copy, std::filesystem::copy_options::recursive);
  EXPECT_EQ(log_hash(read_log(copy)), log_hash(log_));
  std::filesystem::resize_file(copy / log_.images[0].file, 10);
  EXPECT_NE(log_hash(read_log(copy)), log_hash(log_));
  Log later = log_;
  later.images[0].time_end_s += 0.001;
  EXPECT_NE(log_hash(later), log_hash(log_));
}

TEST_F(TrainingTest, HasNothingToShowBeforeItIsPrepared) {
  const Training training(test::device(), log_, options(1));
  EXPECT_THROW((void)training.scene(), Error);
  EXPECT_THROW((void)training.result(), Error);
}

}  // namespace
}  // namespace simuli

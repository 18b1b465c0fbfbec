#include "optim/trainer.hpp"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <limits>

#include "host/base/error.hpp"
#include "tests/optim/small_street.hpp"

namespace simuli {
namespace {

class TrainerTest : public test::SmallStreet {
 protected:
  static TrainOptions options(int iterations) {
    TrainOptions o;
    o.iterations = iterations;
    o.image_scale = 1.0;
    o.lidar_every = 1;
    return o;
  }
  static Scene train(const TrainOptions& o, TrainReport* report = nullptr) {
    Trainer trainer(Device::best(), log_, initial_scene(), o);
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

  TrainOptions other = options(20);
  other.seed = 2;  // another order of frames
  EXPECT_FALSE((a.camera.params.array() == train(other).camera.params.array()).all());
}

TEST_F(TrainerTest, FramesReloadedFromDiskGiveTheSameBits) {
  TrainOptions no_cache = options(10);
  no_cache.cache_bytes = 0;
  const Scene a = train(options(10));
  const Scene b = train(no_cache);
  EXPECT_TRUE((a.camera.params.array() == b.camera.params.array()).all());
  EXPECT_TRUE((a.lidar.params.array() == b.lidar.params.array()).all());
}

TEST_F(TrainerTest, TrainingRecoversFromWrongColoursAndRanges) {
  Scene scene = initial_scene();
  scene.camera.sh(0).setZero();  // grey
  scene.lidar.mean().col(2).array() += 0.1F;
  Trainer trainer(Device::best(), log_, scene, options(120));
  trainer.step();
  const TrainStatus first = trainer.status();
  const TrainReport report = trainer.run();
  EXPECT_EQ(report.last.iteration, 120);
  EXPECT_GT(report.last.psnr_db, first.psnr_db + 3.0) << first.psnr_db;  // the squared error halves
  EXPECT_LT(report.last.distance_m, 0.7 * first.distance_m) << first.distance_m;
  EXPECT_GT(report.last.drop_accuracy, 0.8);
  EXPECT_EQ(report.rejected_gradients, 0U);
  EXPECT_EQ(report.images, 5U);
  EXPECT_EQ(report.sweeps, 5U);
  EXPECT_FALSE(report.stopped_early);
}

TEST_F(TrainerTest, HeldOutFramesAreNeverRead) {
  Log log = log_;
  log.images[4].file = "images/none.png";
  log.sweeps[4].file = "sweeps/none.exr";
  TrainOptions o = options(12);  // more than two epochs
  EXPECT_NO_THROW((void)Trainer(Device::best(), log, initial_scene(), o).run());
  o.held_out_every = 0;
  EXPECT_THROW((void)Trainer(Device::best(), log, initial_scene(), o).run(), Error);
}

TEST_F(TrainerTest, TimeLimitStopsEarlyAndSaysSo) {
  TrainOptions o = options(1'000'000);
  o.max_seconds = 1e-9;
  TrainReport report;
  const Scene scene = train(o, &report);
  EXPECT_TRUE(report.stopped_early);
  EXPECT_LT(report.last.iteration, 10);
  EXPECT_EQ(scene.camera.size(), initial_scene().camera.size());
}

TEST_F(TrainerTest, SweepsTakeTheirTurns) {
  TrainOptions o = options(2);
  o.lidar_every = 2;
  Trainer trainer(Device::best(), log_, initial_scene(), o);
  trainer.step();
  const Eigen::MatrixXf first = trainer.scene().lidar.params;
  trainer.step();
  EXPECT_TRUE((trainer.scene().lidar.params.array() == first.array()).all());
  EXPECT_FALSE((initial_scene().lidar.params.array() == first.array()).all());
}

TEST_F(TrainerTest, MaskedFramesTeachNothing) {
  // Every voxel moved, so every return and every pixel near one is unknown.
  const Scene scene = initial_scene();
  PointSet points;
  points.position = scene.lidar.mean().transpose();
  points.intensity.assign(static_cast<std::size_t>(points.position.cols()), 0.5F);
  const MovingSpace everywhere(50.0, points, std::vector<bool>(points.size(), true));
  TrainOptions o = options(1);
  o.weights.drop = 0.0;  // rays without a return are known
  o.mask_moving = true;
  Trainer masked(Device::best(), log_, scene, o, everywhere);
  masked.step();
  EXPECT_TRUE((masked.scene().lidar.params.array() == scene.lidar.params.array()).all());
  EXPECT_EQ(masked.status().distance_m, 0.0);
  o.mask_moving = false;
  Trainer unmasked(Device::best(), log_, scene, o, everywhere);
  unmasked.step();
  EXPECT_FALSE((unmasked.scene().lidar.params.array() == scene.lidar.params.array()).all());
  EXPECT_NE(unmasked.status().psnr_db, masked.status().psnr_db);
}

TEST_F(TrainerTest, SetsWithoutParticlesAreLeftAlone) {
  Scene scene = initial_scene();
  scene.camera = GaussianSet(SetKind::kCamera, 0, 0);
  Trainer trainer(Device::best(), log_, scene, options(2));
  const TrainReport report = trainer.run();
  EXPECT_TRUE(std::isnan(report.last.psnr_db));
  EXPECT_TRUE(std::isfinite(report.last.distance_m));
  EXPECT_EQ(trainer.scene().camera.size(), 0);
}

TEST_F(TrainerTest, OptionsOutsideTheirRangeAreUsageErrors) {
  const double kNaN = std::numeric_limits<double>::quiet_NaN();
  const auto expect_refused = [](const std::function<void(TrainOptions&)>& change) {
    TrainOptions o = options(1);
    change(o);
    try {
      Trainer(Device::best(), log_, Scene{}, o).step();
      ADD_FAILURE() << "accepted";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kUsage) << error.what();
    }
  };
  expect_refused([](TrainOptions& o) { o.iterations = -1; });
  expect_refused([](TrainOptions& o) { o.lidar_every = 0; });
  expect_refused([](TrainOptions& o) { o.held_out_every = 1; });
  expect_refused([](TrainOptions& o) { o.image_scale = 0.0; });
  expect_refused([&](TrainOptions& o) { o.image_scale = kNaN; });
  expect_refused([&](TrainOptions& o) { o.max_seconds = kNaN; });
  expect_refused([](TrainOptions& o) { o.camera.mean_m = 0.0; });
  expect_refused([&](TrainOptions& o) { o.lidar.sh = kNaN; });
  expect_refused([](TrainOptions& o) { o.weights.drop = -1.0; });
}

TEST_F(TrainerTest, LogWithoutTrainingFramesIsAnInputError) {
  Log log = log_;
  log.images.clear();
  log.sweeps.clear();
  try {
    Trainer(Device::best(), log, Scene{}, options(1)).step();
    ADD_FAILURE() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInput) << error.what();
  }
}

}  // namespace
}  // namespace simuli

// Tests trainings of automatic length.
#include "optim/train/length.hpp"

#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "optim/train/trainer.hpp"
#include "optim/train/training.hpp"
#include "tests/host/expect_error.hpp"
#include "tests/optim/small_street.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

constexpr LengthOptions kDoubling{.automatic = true, .growth = 2.0, .gain_db = 0.5, .gain_share = 0.05};

TEST(TrainLength, TheFirstStageIsAsLongAsItsFramesAskFor) {
  EXPECT_EQ(TrainLength(kDoubling, 40, 50, 50).first(), 400);
  EXPECT_EQ(TrainLength(kDoubling, 4, 5, 5).first(), 100);  // minimum for the decay of learning rates
  LengthOptions capped = kDoubling;
  capped.most = 60;
  EXPECT_EQ(TrainLength(capped, 40, 50, 50).first(), 60);
}

/// Returns the iterations at the ends of all stages for frame errors square(n) and loss(n) after n
/// iterations.
template <class Square, class Loss>
std::vector<int> stages_of(const LengthOptions& options, const Square& square, const Loss& loss) {
  TrainLength length(options, 10, 2, 1);
  std::vector<int> stages;
  for (int n = length.first(); n != 0; n = length.end_stage(n)) {
    stages.push_back(n);
    length.add_image(0, square(n));
    length.add_image(1, square(n));
    length.add_sweep(0, loss(n));
  }
  return stages;
}
constexpr auto kStill = [](int) { return 1.0; };

TEST(TrainLength, GoesOnAsLongAsOneSetGains) {
  // One dB per doubling until 400 iterations, then none.
  const auto square = [](int n) { return std::pow(10.0, -0.1 * std::log2(std::min(n, 400))); };
  EXPECT_EQ(stages_of(kDoubling, square, kStill), (std::vector{100, 200, 400, 800}));
  EXPECT_EQ(stages_of(kDoubling, kStill, kStill), (std::vector{100, 200}));
  const auto loss = [](int n) { return std::pow(0.9, std::log2(std::min(n, 200))); };
  EXPECT_EQ(stages_of(kDoubling, kStill, loss), (std::vector{100, 200, 400}));
  // Half a dB in a stage that is half longer is more than half a dB per doubling.
  LengthOptions shorter = kDoubling;
  shorter.growth = 1.5;
  const auto slow = [](int n) { return std::pow(10.0, -0.06 * std::log2(n)); };
  EXPECT_EQ(stages_of(shorter, slow, kStill).back(), shorter.most);
  shorter.gain_db = 0.7;
  EXPECT_EQ(stages_of(shorter, slow, kStill), (std::vector{100, 150}));
}

TEST(TrainLength, NeverBeyondTheMostAndWithoutASetByTheOther) {
  LengthOptions capped = kDoubling;
  capped.most = 500;
  EXPECT_EQ(stages_of(
                capped, [](int n) { return 1.0 / n; }, kStill),
            (std::vector{100, 200, 400, 500}));
  const auto none = [](int) { return std::nan(""); };
  EXPECT_EQ(stages_of(kDoubling, none, kStill), (std::vector{100, 200}));
  EXPECT_EQ(stages_of(kDoubling, none, none), (std::vector{100, 200}));
}

class AutoTraining : public test::SmallStreet {
 protected:
  static TrainingOptions options() {
    TrainingOptions o;
    o.frames.image_scale = 1.0;
    o.init.voxel_m = 0.3;
    o.init.sweep_depth = false;
    o.train.lidar_every = 2;
    o.train.length = {.automatic = true,
                      .first_epochs = 1.0,
                      .growth = 1.2,
                      .gain_db = 0.0,
                      .gain_share = 1.0,
                      .most = 144};
    return o;
  }
  static void expect_same(const Scene& found, const Scene& expected) {
    EXPECT_EQ(found.camera.params, expected.camera.params);
    EXPECT_EQ(found.lidar.params, expected.lidar.params);
  }
};

TEST_F(AutoTraining, IsTheChainOfItsStages) {
  TrainingOptions o = options();
  Training automatic(test::device(), log_, o);
  const TrainReport report = automatic.run().train;
  ASSERT_EQ(report.stages.size(), 3U);
  EXPECT_EQ(report.stages[0].iterations, 100);
  EXPECT_EQ(report.stages[1].iterations, 120);
  EXPECT_EQ(report.stages[2].iterations, 144);
  EXPECT_GT(report.stages[1].gain_db, 0.0);
  EXPECT_LT(report.stages[2].square, report.stages[0].square);
  const TrainingRecord record = *automatic.result().training;
  EXPECT_EQ(record.iterations, 144);
  EXPECT_EQ(record.planned_iterations, 144);
  // Trainings with these lengths, each resumed from the end of the previous one.
  o.train.length.automatic = false;
  const std::filesystem::path file = folder_ / "chain.checkpoint";
  std::optional<Scene> last;
  for (const int iterations : {100, 120, 144}) {
    o.train.iterations = iterations;
    Training reported(test::device(), log_, o);
    if (last) reported.resume(file);
    reported.run({}, {file, 1000});
    last = reported.scene();
  }
  expect_same(automatic.scene(), *last);
}

TEST_F(AutoTraining, GoesOnFromItsCheckpointsWithTheSameBits) {
  const TrainingOptions o = options();
  Training whole(test::device(), log_, o);
  whole.run([&](const TrainStatus& status) {
    // In the first stage, at its end, in the last stage.
    for (const int at : {50, 100, 130}) {
      if (status.iteration == at) whole.save(folder_ / fmt::format("auto_{}.checkpoint", at));
    }
  });
  for (const int at : {50, 100, 130}) {
    Training resumed(test::device(), log_, o);
    resumed.resume(folder_ / fmt::format("auto_{}.checkpoint", at));
    EXPECT_EQ(resumed.status().planned, at < 100 ? 100 : at < 120 ? 120 : 144);
    const TrainReport& report = resumed.run().train;
    expect_same(resumed.scene(), whole.scene());
    ASSERT_EQ(report.stages.size(), 3U) << at;
    EXPECT_EQ(report.stages[2].gain_db, whole.report().train.stages[2].gain_db);
  }
  TrainingOptions other = o;
  other.train.length.automatic = false;
  Training refused(test::device(), log_, other);
  expect_error(ErrorKind::kInput, "settings: found auto.on=true, allowed auto.on=false", [&] {
    refused.resume(folder_ / "auto_50.checkpoint");
  });
}

TEST_F(AutoTraining, EndsWhenLittleIsGained) {
  TrainingOptions o = options();
  o.train.length.gain_db = 1000.0;
  Training training(test::device(), log_, o);
  EXPECT_EQ(training.run().train.last.iteration, 120);
  EXPECT_EQ(training.result().training->iterations, 120);
}

}  // namespace
}  // namespace simuli

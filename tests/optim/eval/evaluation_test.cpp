#include "optim/eval/evaluation.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <string>
#include <variant>

#include "host/core/base/error.hpp"
#include "host/device/render/scene/readings.hpp"
#include "optim/base/frames.hpp"
#include "optim/eval/sweep_pair.hpp"
#include "tests/optim/small_street.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using test::compare;

const EvalOptions kFull{.image_scale = 1.0};
constexpr double kInfinity = std::numeric_limits<double>::infinity();

class EvaluationTest : public test::SmallStreet {
 protected:
  /// Returns the street's log with frame 4 replaced by a render of `scene`.
  static Log log_of(const Scene& scene, const std::string& name) {
    Log log = log_;
    log.folder = folder_ / name;
    fs::create_directories(log.folder / "images");
    fs::create_directories(log.folder / "sweeps");
    SceneOnDevice on_device(test::device(), borrowed(scene));
    const ImageFrame& image = log.images[4];
    const Sensor camera(log.camera(image.camera).model);
    write_image(log.folder / image.file, on_device.render(camera, shot_of(log, image)).image());

    SweepPair pair = render_sweep(on_device, log_, log_.sweeps[4]);
    for (std::size_t i = 0; i < pair.recorded.range.size(); ++i) {
      const bool returns = pair.simulated.drop_probability(i) <= 0.5F;
      pair.recorded.range[i] = returns ? best_distance(pair.simulated, i) : 0.0F;
      pair.recorded.intensity[i] = returns ? std::clamp(pair.simulated.feature[0][i], 0.0F, 1.0F) : 0.0F;
    }
    write_sweep(log.folder / log.sweeps[4].file, pair.recorded);
    return log;
  }
};

TEST_F(EvaluationTest, SceneAgreesWithALogMadeOfIt) {
  const Scene scene = initial_scene();
  const Log log = log_of(scene, "self.log");
  const EvalReport r = compare(log, scene, kFull);
  EXPECT_EQ(r.images, 1U);
  EXPECT_EQ(r.sweeps, 1U);
  // Pictures have 8 bits: rounding of +-1/510 gives 59 dB.
  EXPECT_GT(r.psnr_db, 55.0);
  EXPECT_GT(r.ssim, 0.99);
  EXPECT_EQ(r.lidar.distance_median_m, 0.0);  // sweeps are stored in float
  EXPECT_EQ(r.lidar.medl2_m2, 0.0);
  EXPECT_EQ(r.lidar.mean_rel_l2, 0.0);
  EXPECT_EQ(r.lidar.intensity_rmse, 0.0);
  EXPECT_EQ(r.lidar.raydrop_accuracy, 1.0);
  EXPECT_EQ(r.lidar.chamfer_m, 0.0);
  EXPECT_LT(r.distance_expected_median_m, 0.05);  // equals the mean, except for rays on several surfaces
  EXPECT_GT(r.camera_mp_per_s, 0.0);
  EXPECT_GT(r.lidar_mr_per_s, 0.0);
  EXPECT_EQ(r.image_width, 64);
  EXPECT_EQ(r.image_height, 36);
}

TEST_F(EvaluationTest, ShiftedSceneIsOffByTheShift) {
  const Scene scene = initial_scene();
  const Log log = log_of(scene, "shift.log");
  Scene nearer = scene;
  nearer.lidar.mean().col(0).array() += 0.5F;  // along the street: ranges ahead and behind change by less
  const EvalReport r = compare(log, nearer, kFull);
  EXPECT_GT(r.lidar.distance_median_m, 0.001);
  EXPECT_LT(r.lidar.distance_median_m, 0.5);
  // For an even number the median is the mean of two, which differs for squares.
  EXPECT_NEAR(std::sqrt(r.lidar.medl2_m2), r.lidar.distance_median_m, 1e-5);
}

TEST_F(EvaluationTest, HalfSizeComparesHalfSizePictures) {
  const EvalReport r = compare(log_, initial_scene(), {.image_scale = 0.5});
  EXPECT_EQ(r.image_width, 32);
  EXPECT_EQ(r.image_height, 18);
  EXPECT_TRUE(std::isfinite(r.psnr_db));
}

TEST_F(EvaluationTest, MissingSensorsAreNaN) {
  Log log = log_;
  log.images.clear();
  const EvalReport r = compare(log, initial_scene(), kFull);
  EXPECT_TRUE(std::isnan(r.psnr_db));
  EXPECT_TRUE(std::isnan(r.camera_mp_per_s));
  EXPECT_TRUE(std::isfinite(r.lidar.distance_median_m));
}

TEST_F(EvaluationTest, NothingHeldOutOrBadOptionsAreRefused) {
  Log log = log_;
  log.images.resize(4);
  log.sweeps.resize(4);
  EXPECT_THROW((void)compare(log, initial_scene(), kFull), Error);
  EvalOptions options = kFull;
  options.held_out_every = 0;
  EXPECT_EQ(compare(log, initial_scene(), options).images, 4U);
  options.held_out_every = 1;
  EXPECT_THROW((void)compare(log, initial_scene(), options), Error);
  options = kFull;
  options.timed_renders = 0;
  EXPECT_THROW((void)compare(log_, initial_scene(), options), Error);
}

/// Returns the scene with the record of a training on `log` with `frames`.
SceneFile trained_on(const Log& log, Scene scene, const FrameSelection& frames) {
  SceneFile file = test::file_of(log, std::move(scene));
  file.training = TrainingRecord{.log_name = log.name, .log_hash = log_hash(log), .frames = frames};
  return file;
}

TEST_F(EvaluationTest, FramesAreThoseThatTrainingHeldOut) {
  const SceneFile scene = trained_on(log_, initial_scene(), {.image_scale = 0.5, .held_out_every = 3});
  const EvalFrames frames = select_eval_frames(log_, scene);
  EXPECT_EQ(frames.kind, FrameKind::kHeldOut);
  EXPECT_EQ(frames.label(), "held-out frames");
  EXPECT_EQ(frames.requested.image_scale, 0.5);
  EXPECT_EQ(frames.images, (std::vector<std::size_t>{2, 5}));
  EXPECT_EQ(frames.sweeps, (std::vector<std::size_t>{2, 5}));
  const EvalReport report = Evaluation(test::device(), scene, log_).run();
  EXPECT_EQ(report.image_width, 32);
  EXPECT_EQ(report.images, 2U);
  EXPECT_EQ(report.frames.kind, FrameKind::kHeldOut);
}

TEST_F(EvaluationTest, NothingIsCalledHeldOutThatWasTrainedOn) {
  const auto kind = [&](int trained, std::optional<int> requested) {
    const SceneFile scene = trained_on(log_, initial_scene(), {.held_out_every = trained});
    return select_eval_frames(log_, scene, {.held_out_every = requested});
  };
  EXPECT_EQ(kind(0, {}).kind, FrameKind::kTraining);
  EXPECT_EQ(kind(0, {}).label(), "training frames");
  EXPECT_EQ(kind(0, {}).images.size(), 6U);
  EXPECT_EQ(kind(0, 5).kind, FrameKind::kTraining);
  EXPECT_EQ(kind(5, 0).kind, FrameKind::kMixed);
  EXPECT_EQ(kind(5, 0).label(), "all frames, some of which were trained on");
  EXPECT_EQ(kind(5, 2).kind, FrameKind::kTraining);  // 1, 3, 5
  EXPECT_EQ(kind(3, 2).kind, FrameKind::kMixed);     // frame 5 is also one of every third
  EXPECT_EQ(kind(2, 6).kind, FrameKind::kHeldOut);   // every third is one of every second
}

TEST_F(EvaluationTest, AnotherLogHasNoHeldOutFrames) {
  const SceneFile scene = trained_on(log_, initial_scene(), {});
  Log other = log_;
  other.images.pop_back();
  const EvalFrames all = select_eval_frames(other, scene);
  EXPECT_EQ(all.kind, FrameKind::kOtherLog);
  EXPECT_EQ(all.images.size(), 5U);
  EXPECT_EQ(all.sweeps.size(), 6U);
  const EvalFrames some = select_eval_frames(other, scene, {.held_out_every = 5});
  EXPECT_EQ(some.kind, FrameKind::kOtherLog);
  EXPECT_EQ(some.label(), "every 5. frame of a log that was not trained on");
  EXPECT_EQ(some.images.size(), 1U);
  // A scene without a record is not trusted.
  const EvalFrames unknown = select_eval_frames(log_, test::file_of(log_, initial_scene()));
  EXPECT_EQ(unknown.kind, FrameKind::kUnknown);
  EXPECT_EQ(unknown.label().find("held"), std::string::npos);
}

TEST_F(EvaluationTest, TheEndOfTheTrajectoryIsSeparate) {
  // Six evenly spaced frames with pictures in the middle of sweeps: the last third has two frames.
  const SceneFile scene = trained_on(log_, initial_scene(), {.held_out_every = 3, .held_out_last = 0.3});
  const EvalFrames frames = select_eval_frames(log_, scene);
  EXPECT_EQ(frames.images, (std::vector<std::size_t>{2, 4, 5}));
  EXPECT_EQ(frames.kind, FrameKind::kHeldOut);
  EXPECT_EQ(frames.image_uses[2], FrameUse::kBetween);
  EXPECT_EQ(frames.image_uses[5], FrameUse::kBeyond);  // also one of every third, but beyond the cut
  const EvalReport r = Evaluation(test::device(), scene, log_).run();
  ASSERT_TRUE(r.between && r.beyond);
  EXPECT_EQ(r.images, 3U);
  EXPECT_EQ(r.between->images, 1U);
  EXPECT_EQ(r.beyond->images, 2U);
  EXPECT_NEAR(r.psnr_db, (r.between->psnr_db + 2.0 * r.beyond->psnr_db) / 3.0, 1e-9);
  EXPECT_EQ(r.sweeps, r.between->sweeps + r.beyond->sweeps);
  // A single requested part is the only compared part, with its relation to the training.
  const EvalFrames end = select_eval_frames(log_, scene, {.held_out_last = 0.3});
  EXPECT_EQ(end.images, (std::vector<std::size_t>{4, 5}));
  EXPECT_EQ(end.label(), "held-out frames at the end of the path");
  const EvalFrames third = select_eval_frames(log_, scene, {.held_out_every = 3});
  EXPECT_EQ(third.images, (std::vector<std::size_t>{2, 5}));
  EXPECT_TRUE(third.has(FrameUse::kBeyond));
  EXPECT_EQ(select_eval_frames(log_, scene, {.held_out_every = 2}).kind, FrameKind::kMixed);  // 1, 3, 5
  EXPECT_EQ(select_eval_frames(log_, scene, {.held_out_every = 0}).images.size(), 6U);
}

TEST_F(EvaluationTest, TheMiddleOfTheTrajectoryIsSeparate) {
  // The middle third of six evenly spaced frames is 2 and 3.
  const SceneFile scene = trained_on(log_, initial_scene(), {.held_out_every = 5, .held_out_middle = 0.3});
  const EvalFrames frames = select_eval_frames(log_, scene);
  EXPECT_EQ(frames.images, (std::vector<std::size_t>{2, 3, 4}));
  EXPECT_EQ(frames.image_uses[3], FrameUse::kMiddle);
  const EvalReport r = Evaluation(test::device(), scene, log_).run();
  ASSERT_TRUE(r.between && r.middle && !r.beyond);
  EXPECT_EQ(r.between->images, 1U);
  EXPECT_EQ(r.middle->images, 2U);
  EXPECT_NEAR(r.psnr_db, (r.between->psnr_db + 2.0 * r.middle->psnr_db) / 3.0, 1e-9);
  const EvalFrames middle = select_eval_frames(log_, scene, {.held_out_middle = 0.3});
  EXPECT_EQ(middle.images, (std::vector<std::size_t>{2, 3}));
  EXPECT_EQ(middle.label(), "held-out frames in the middle of the path");
  // Middle and end without frames between: two parts, and the label contains both.
  const SceneFile both =
      trained_on(log_, initial_scene(), {.held_out_every = 0, .held_out_middle = 0.3, .held_out_last = 0.1});
  const EvalReport parts = Evaluation(test::device(), both, log_).run();
  EXPECT_TRUE(!parts.between && parts.middle && parts.beyond);
  EXPECT_EQ(parts.frames.label(), "held-out frames in the middle and at the end of the path");
  // The middle of another selection also contains training frames.
  EXPECT_EQ(select_eval_frames(log_, scene, {.held_out_middle = 0.6}).kind, FrameKind::kMixed);
}

TEST_F(EvaluationTest, RangesShareOutAllReturns) {
  const EvalReport r = compare(log_, initial_scene(), kFull);
  ASSERT_EQ(r.ranges.size(), RangeScores::kFrom_m.size());
  const Sweep sweep = read_sweep(log_.folder / log_.sweeps[4].file, log_.lidars[0].model);
  for (std::size_t k = 0; k < r.ranges.size(); ++k) {
    const double to_m = k + 1 < r.ranges.size() ? RangeScores::kFrom_m[k + 1] : kInfinity;
    const auto here = std::count_if(sweep.range.begin(), sweep.range.end(), [&](float range) {
      return range > 0.0F && range >= RangeScores::kFrom_m[k] && range < to_m;
    });
    EXPECT_EQ(r.ranges[k].returns, static_cast<std::size_t>(here)) << k;
    EXPECT_EQ(std::isfinite(r.ranges[k].distance_median_m), here > 0) << k;
  }
  EXPECT_GT(r.ranges[1].returns, 0U);
  EXPECT_GT(r.ranges[0].pixels, 0U);
  EXPECT_TRUE(std::isfinite(r.ranges[0].psnr_db));
  EXPECT_TRUE(r.kinds.empty());  // no moving actors
}

TEST_F(EvaluationTest, ErrorsStandAtTheirOwnRange) {
  // A log that equals the scene, except for returns beyond 20 m, which are 1 m too short.
  const Scene scene = initial_scene();
  Log log = log_of(scene, "ranges.log");
  const std::filesystem::path file = log.folder / log.sweeps[4].file;
  Sweep sweep = read_sweep(file, log.lidars[0].model);
  for (float& range : sweep.range) range += range > 20.0F ? 1.0F : 0.0F;
  write_sweep(file, sweep);
  const EvalReport r = compare(log, scene, kFull);
  EXPECT_EQ(r.ranges[0].distance_mean_m, 0.0);
  EXPECT_EQ(r.ranges[1].distance_mean_m, 0.0);
  EXPECT_NEAR(r.ranges[2].distance_median_m, 1.0, 1e-5);
  EXPECT_EQ(r.ranges[0].share_dropped, 0.0);
  EXPECT_EQ(r.ranges[0].returns_of_nothing, 0U);
}

TEST_F(EvaluationTest, RaysThatAreNeverFiredCountForNothing) {
  const Scene scene = initial_scene();
  Log log = log_of(scene, "half.log");
  const double whole = compare(log, scene, kFull).lidar.raydrop_trivial;
  Lidar half = log.lidars[0].with_rows();
  for (LidarRow& row : half.rows) row.every = 2;
  const std::filesystem::path file = log.folder / log.sweeps[4].file;
  Sweep sweep = read_sweep(file, log.lidars[0].model);
  for (std::size_t i = 0; i < sweep.range.size(); ++i) {
    if (!fires(half, i)) sweep.range[i] = sweep.intensity[i] = 0.0F;
  }
  write_sweep(file, sweep);
  log.lidars[0].model = half;
  EXPECT_NEAR(compare(log, scene, kFull).lidar.raydrop_trivial, whole, 0.02);  // otherwise half of it
}

TEST_F(EvaluationTest, KindsPartActorsFromTheBackground) {
  // Two adjacent moving boxes, the narrow one nearer and within the wide one.
  Log log = log_;
  const auto add = [&](const char* name, const char* kind, double x_m, double side_m) {
    Actor actor{name, kind, Eigen::Vector3d(4.0, side_m, 4.0), {}};
    for (const double time_s : {0.0, 1.0}) {
      actor.track.push_back({time_s, {Eigen::Quaterniond::Identity(), {x_m + 8.0 * time_s, 0.0, 1.0}}});
    }
    log.actors.push_back(actor);
  };
  add("far", "truck", 30.0, 12.0);
  add("near", "car", 20.0, 3.0);
  add("second", "car", 12.0, 1.0);
  const EvalReport r = compare(log, initial_scene(), kFull);
  ASSERT_EQ(r.kinds.size(), 3U);
  EXPECT_EQ(r.kinds[0].kind, "truck");
  EXPECT_EQ(r.kinds[1].kind, "car");
  EXPECT_EQ(r.kinds[2].kind, KindScores::kBackground);
  EXPECT_GT(r.kinds[0].pixels, 0U);
  EXPECT_GT(r.kinds[1].pixels, 0U);
  EXPECT_EQ(r.kinds[0].pixels + r.kinds[1].pixels, r.actor_pixels);
  EXPECT_EQ(r.actor_pixels + r.kinds[2].pixels, 64U * 36U);
  std::size_t returns = 0, in_ranges = 0;
  for (const KindScores& kind : r.kinds) returns += kind.returns;
  for (const RangeScores& range : r.ranges) in_ranges += range.returns;
  EXPECT_EQ(returns, in_ranges);
  EXPECT_TRUE(std::isfinite(r.kinds[2].psnr_db));
  // The kinds sum to the squared error of the picture.
  const auto square = [](const KindScores& k) {
    return static_cast<double>(k.pixels) * std::pow(10.0, -0.1 * k.psnr_db);
  };
  const double all = square(r.kinds[0]) + square(r.kinds[1]) + square(r.kinds[2]);
  EXPECT_NEAR(-10.0 * std::log10(all / (64.0 * 36.0)), r.psnr_db, 1e-9);
}

TEST_F(EvaluationTest, SensorsAreWhereTheSceneHasThem) {
  const SceneFile scene = test::file_of(log_, initial_scene());
  const EvalReport expected = Evaluation(test::device(), scene, log_, kFull).run();
  Log wrong = log_;  // the training refines this pose
  wrong.cameras[0].rig_from_camera.translation.y() += 0.2;
  wrong.lidars[0].rig_from_lidar.translation.z() += 0.2;
  const EvalReport found = Evaluation(test::device(), scene, wrong, kFull).run();
  EXPECT_EQ(found.psnr_db, expected.psnr_db);
  EXPECT_EQ(found.lidar.distance_median_m, expected.lidar.distance_median_m);
}

TEST_F(EvaluationTest, TheOwnVehicleIsNotCompared) {
  SceneFile scene = test::file_of(log_, initial_scene());
  const EvalReport whole = Evaluation(test::device(), scene, log_, kFull).run();
  EXPECT_EQ(whole.share_own, 0.0);
  const auto returns_of = [](const EvalReport& report) {
    std::size_t sum = 0;
    for (const RangeScores& range : report.ranges) sum += range.returns + range.returns_of_nothing;
    return sum;
  };
  Lidar& lidar = std::get<Lidar>(scene.lidars[0].model);
  const double turn = 2.0 * std::numbers::pi;
  const int last = static_cast<int>(lidar.rows.size()) - 1;  // measures the ground all around
  lidar.blind.push_back({last, 0.0, turn});
  // marked as blind in all directions
  const EvalReport dark = Evaluation(test::device(), scene, log_, kFull).run();
  EXPECT_EQ(dark.share_own, 0.0);
  EXPECT_NE(dark.lidar.raydrop_accuracy, whole.lidar.raydrop_accuracy);  // the blind arcs have an effect
  lidar.blind[0].own_returns = true;
  Evaluation blind(test::device(), scene, log_, kFull);
  const EvalReport report = blind.run();
  EXPECT_NEAR(report.share_own, 1.0 / static_cast<double>(lidar.rows.size()), 1e-12);
  EXPECT_LE(returns_of(report), returns_of(whole) - static_cast<std::size_t>(lidar.columns) / 2);
  EXPECT_NEAR(report.lidar.raydrop_accuracy, whole.lidar.raydrop_accuracy, 0.1);
  // The log read with the scene's calibration also omits them.
  const LidarPair pair = blind.sweep(4);
  for (std::size_t i = pair.recorded.range.size() - static_cast<std::size_t>(lidar.columns);
       i < pair.recorded.range.size();
       ++i) {
    ASSERT_EQ(pair.recorded.range[i], 0.0F) << i;
    ASSERT_EQ(pair.recorded.intensity[i], 0.0F) << i;
  }
}

TEST_F(EvaluationTest, LabelsThatCannotBeAreTold) {
  const SceneFile scene = test::file_of(log_, initial_scene());
  Log log = log_;
  Actor car{"taxi", "car", Eigen::Vector3d(4.0, 2.0, 1.5), {}};
  for (int i = 0; i < 10; ++i) {
    car.track.push_back({0.1 * i, {Eigen::Quaterniond::Identity(), {20.0 + i, 5.0, 1.0}}});
  }
  log.actors = {car};
  EXPECT_TRUE(Evaluation(test::device(), scene, log, kFull).run().warnings.empty());
  log.actors[0].track[5].world_from_actor.rotation =
      Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ());
  const std::vector<std::string> warnings = Evaluation(test::device(), scene, log, kFull).run().warnings;
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("taxi"), std::string::npos) << warnings[0];
}

TEST_F(EvaluationTest, LabelsThatTrainingLeftOutAreNotScored) {
  Log log = log_;
  Actor wide{"wide", "truck", Eigen::Vector3d(12.0, 4.0, 4.0), {}};
  for (const double time_s : {0.0, 1.0}) {
    wide.track.push_back({time_s, {Eigen::Quaterniond::Identity(), {30.0 + 8.0 * time_s, 0.0, 1.0}}});
  }
  log.actors = {wide};
  SceneFile scene = trained_on(log, initial_scene(), {.held_out_every = 3});
  const auto report = [&] { return Evaluation(test::device(), scene, log, kFull).run(); };
  EXPECT_GT(report().actor_pixels, 0U);  // also for a scene without the actor
  scene.training->labels_left_out = {"wide"};
  const EvalReport left_out = report();
  EXPECT_EQ(left_out.actor_pixels, 0U);
  ASSERT_EQ(left_out.warnings.size(), 1U);
  EXPECT_NE(left_out.warnings[0].find("wide: left out"), std::string::npos) << left_out.warnings[0];
}

TEST_F(EvaluationTest, RangeBiasesOfTheSceneCorrectRangesAndAreStatedAgain) {
  constexpr double kBias_m = 0.25;
  SceneFile scene = test::file_of(log_, initial_scene());
  Evaluation unbiased(test::device(), scene, log_, kFull);
  const LidarPair plain = unbiased.sweep(4);
  for (LidarRow& row : std::get<Lidar>(scene.lidars[0].model).rows) row.range_bias = kBias_m;
  Evaluation biased(test::device(), scene, log_, kFull);
  const LidarPair pair = biased.sweep(4);
  // the scene assumes a bias that the sweeps do not have
  EXPECT_NEAR(biased.run().lidar.distance_median_m, kBias_m, 0.1);
  for (std::size_t i = 0; i < pair.recorded.range.size(); ++i) {
    ASSERT_NEAR(pair.recorded.range[i], plain.recorded.range[i], 1e-5) << i;  // as in the file
    if (pair.rendered.is_return(i) && plain.rendered.is_return(i)) {
      ASSERT_NEAR(pair.rendered.range[i], plain.rendered.range[i] + kBias_m, 1e-4) << i;
    }
  }
}

TEST(ScaledCamera, SidesAreRoundedUp) {
  const Camera camera{"c", 1242, 375, 700.0, 700.0, 600.0, 180.0, ShutterKind::kGlobal};
  const Camera half = scaled_camera(camera, 0.5);
  EXPECT_EQ(half.width, 621);
  EXPECT_EQ(half.height, 188);
  EXPECT_DOUBLE_EQ(half.fy, 700.0 * 188.0 / 375.0);
  EXPECT_EQ(scaled_camera(camera, 0.1).width, 125);
  EXPECT_EQ(scaled_camera(camera, 5e-4).width, 1);
  for (const double none : {0.0, 1e-9, 4e-4}) EXPECT_THROW((void)scaled_camera(camera, none), Error);
  EXPECT_THROW((void)scaled_camera(camera, std::nan("")), Error);
}

}  // namespace
}  // namespace simuli

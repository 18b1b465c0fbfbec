// Tests drives that are cut into chunks along their trajectory.
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <utility>

#include "host/core/record/support_record.hpp"
#include "host/core/scene/occluders.hpp"
#include "io/synth/long_street.hpp"
#include "optim/eval/evaluation.hpp"
#include "optim/init/posed_frames.hpp"
#include "optim/train/chunk/chunk_parts.hpp"
#include "optim/train/chunk_plan.hpp"
#include "optim/train/memory.hpp"
#include "optim/train/training.hpp"
#include "tests/host/expect_error.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

constexpr double kLength_m = 60.0;
constexpr int kFrames = 30;

/// 60 m of the long street with traffic, generated once; 30 pictures and 30 sweeps, 24 of each for training.
class ChunksTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::string pattern = (fs::temp_directory_path() / "simuli_stretches_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    LongStreetOptions options;
    options.output = folder_ / "street.log";
    options.length_m = kLength_m;
    options.frames = kFrames;
    options.cameras = options.lidars = 1;
    options.image_width = 48;
    options.image_height = 27;
    options.lidar_columns = 60;
    log_ = synth_long_street(options);
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }

  static TrainingOptions options(double stretch_m, int iterations = 60) {
    TrainingOptions o;
    o.frames.image_scale = 1.0;
    o.init.voxel_m = 0.3;
    o.init.sweep_depth = false;
    o.refine_path = false;
    o.train.iterations = iterations;
    o.train.densify.epochs = 0.5;
    o.train.prune.first = 0;
    o.chunks = {.length_m = stretch_m, .overlap_m = 40.0};
    return o;
  }
  static void expect_same(const Scene& found, const Scene& expected) {
    EXPECT_EQ(found.camera.params, expected.camera.params);
    EXPECT_EQ(found.camera.actor, expected.camera.actor);
    EXPECT_EQ(found.lidar.params, expected.lidar.params);
    EXPECT_EQ(found.lidar.actor, expected.lidar.actor);
    EXPECT_EQ(found.environment.texels, expected.environment.texels);
    EXPECT_EQ(found.camera_background, expected.camera_background);
    EXPECT_EQ(found.ray_drop, expected.ray_drop);
    ASSERT_EQ(found.actors.size(), expected.actors.size());
    for (std::size_t i = 0; i < found.actors.size(); ++i) {
      for (std::size_t k = 0; k < found.actors[i].track.size(); ++k) {
        EXPECT_EQ(found.actors[i].track[k].shift_m, expected.actors[i].track[k].shift_m);
        EXPECT_EQ(found.actors[i].track[k].turn_rad, expected.actors[i].track[k].turn_rad);
      }
    }
  }

  inline static fs::path folder_;
  inline static Log log_;
};

TEST_F(ChunksTest, CutThePathInEqualPartsThatCoverIt) {
  const DrivenPath path(log_);
  EXPECT_NEAR(path.length_m(), kLength_m, 3.0);
  EXPECT_EQ(cut(path, {}).size(), 1U);
  const std::vector<DriveChunk> chunks = cut(path, {.length_m = 20.0});
  ASSERT_EQ(chunks.size(), 3U);
  EXPECT_EQ(chunks.front().from_m, 0.0);
  EXPECT_EQ(chunks.back().to_m, path.length_m());
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    EXPECT_EQ(chunk_at(chunks, chunks[i].from_m), i);
    EXPECT_EQ(chunk_at(chunks, std::nextafter(chunks[i].to_m, 0.0)), i);
  }
  EXPECT_EQ(chunk_at(chunks, 1e6), 2U);
  EXPECT_EQ(chunk_at(chunks, -1.0), 0U);
  const Eigen::Vector3d origin = scene_origin(log_.world_from_rig);
  for (const SweepFrame& frame : log_.sweeps) {
    const Pose at = log_.world_from_rig.at(frame.time_start_s);
    const Eigen::Vector3d beside = at * Eigen::Vector3d(0.0, 7.0, 1.0) - origin;
    EXPECT_NEAR(path.place_nearest(beside.cast<float>()), path.place_at(frame.time_start_s), 1.0);
  }
}

TEST_F(ChunksTest, HaveTheirOwnTrainingFramesAndThoseOfTheOverlap) {
  const DrivenPath path(log_);
  const FrameSelection frames;
  const HeldOutRule rule(log_, frames);
  std::size_t seen = 0;
  for (const DriveChunk& chunk : cut(path, {.length_m = 20.0})) {
    const Log part = log_of(log_, frames, path, chunk, {.overlap_m = 20.0, .overlap_share = 1.0});
    std::size_t beside = 0, taken = 0;
    for (std::size_t i = 0; i < log_.sweeps.size(); ++i) {
      const SweepFrame& frame = log_.sweeps[i];
      const double position_m = path.place_at(0.5 * (frame.time_start_s + frame.time_end_s));
      const double away_m = std::max(chunk.from_m - position_m, position_m - chunk.to_m);
      const bool is_there = std::any_of(part.sweeps.begin(), part.sweeps.end(), [&](const SweepFrame& own) {
        return own.file == frame.file;
      });
      const bool is_trained = rule.use(i, frame) == FrameUse::kTraining;
      if (away_m <= 0.0) {
        EXPECT_EQ(is_there, is_trained) << i;
      } else if (away_m > 20.0 || !is_trained) {
        EXPECT_FALSE(is_there) << i;
      }
      beside += is_trained && away_m > 0.0 && away_m <= 20.0 ? 1U : 0U;
      taken += is_there && away_m > 0.0 ? 1U : 0U;
    }
    EXPECT_LT(taken, beside / 2);
    EXPECT_GT(taken, 0U);
    seen += part.sweeps.size();
    // The camera points ahead: pictures after the chunk do not show it.
    for (const ImageFrame& frame : part.images) EXPECT_LE(path.place_at(frame.time_start_s), chunk.to_m);
    EXPECT_EQ(path.place_at(part.images.front().time_start_s) < chunk.from_m, chunk.from_m > 0.0);
  }
  EXPECT_GT(seen, rule.training(log_.sweeps).size());  // some in two chunks
}

TEST_F(ChunksTest, OneAloneIsTheTrainingAsItWas) {
  Training whole(test::device(), log_, options(0.0, 20));
  whole.run();
  Training one(test::device(), log_, options(kLength_m, 20));
  one.run();
  expect_same(one.scene(), whole.scene());
}

TEST_F(ChunksTest, KilledAnywhereTheyGoOnToTheSameScene) {
  const fs::path file = folder_ / "killed.checkpoint";
  Training undisturbed(test::device(), log_, options(20.0));
  std::vector<int> reported;
  undisturbed.run([&](const TrainStatus& status) {
    reported.push_back(status.iteration);
    EXPECT_EQ(status.planned, 60);
  });
  ASSERT_EQ(reported.size(), 60U);
  EXPECT_EQ(reported.back(), 60);
  const Scene expected = undisturbed.scene();
  struct Killed {};
  // In the first chunk, at its end, in the second, and twice in the third.
  bool begun = false;
  for (const int at : {13, 20, 33, 47, 58, 1000}) {
    Training training(test::device(), log_, options(20.0));
    if (begun) training.resume(file);
    begun = true;
    try {
      training.run(
          [at](const TrainStatus& status) {
            if (status.iteration >= at) throw Killed();
          },
          {file, 6});
      EXPECT_EQ(at, 1000);
      expect_same(training.scene(), expected);
      EXPECT_EQ(training.report().train.last.iteration, 60);
    } catch (const Killed&) {
    }
  }
  // Finished chunks are kept, and the state of another training is rejected.
  Training finished(test::device(), log_, options(20.0));
  finished.resume(file);
  expect_same(finished.scene(), expected);
  finished.run();
  expect_same(finished.scene(), expected);
  Training longer(test::device(), log_, options(20.0, 90));
  expect_error(ErrorKind::kInput, "iterations=", [&] { longer.resume(file); });
  Training uncut(test::device(), log_, options(0.0));
  expect_error(ErrorKind::kInput, "settings", [&] { uncut.resume(file); });
}

/// Returns the mean PSNR of the held-out pictures that satisfy `is_of`.
template <class F>
double psnr_db(const EvalReport& report, F&& is_of) {
  double sum = 0.0, count = 0.0;
  for (const PictureScore& score : report.picture_scores) {
    if (!is_of(score)) continue;
    sum += score.psnr_db;
    ++count;
  }
  return sum / count;
}

TEST_F(ChunksTest, LeaveNoSeam) {
  const auto report_of = [&](const TrainingOptions& o, std::size_t& particles) {
    Training training(test::device(), log_, o);
    training.run();
    SceneFile scene = training.result();
    particles = static_cast<std::size_t>(scene.scene.lidar.size());
    return Evaluation(test::device(), std::move(scene), log_, EvalOptions{}).run();
  };
  // The same number of iterations for each chunk as for the complete drive: densification depends on it.
  std::size_t whole_particles = 0, particles = 0;
  const EvalReport whole = report_of(options(0.0, 100), whole_particles);
  const EvalReport parts = report_of(options(20.0, 300), particles);
  const DrivenPath path(log_);
  const auto near_seam = [&](const PictureScore& score) {
    const double position_m = path.place_at(score.time_s);
    return std::abs(position_m - 20.0) < 4.0 || std::abs(position_m - 40.0) < 4.0;
  };
  const auto apart = [&](const PictureScore& score) { return !near_seam(score); };
  const double lost_db = psnr_db(whole, apart) - psnr_db(parts, apart);
  const double lost_at_seams_db = psnr_db(whole, near_seam) - psnr_db(parts, near_seam);
  EXPECT_LT(lost_db, 0.7);
  EXPECT_LT(lost_at_seams_db, 0.7);
  EXPECT_LT(parts.lidar.distance_median_m, whole.lidar.distance_median_m + 0.005);
  EXPECT_GT(parts.lidar.raydrop_accuracy, whole.lidar.raydrop_accuracy - 0.02);
  // Each position is covered once, without holes and duplicates. Some positions are only measured by distant
  // sweeps that a chunk does not have: a tenth for chunks as short as these.
  EXPECT_NEAR(static_cast<double>(particles),
              static_cast<double>(whole_particles),
              0.15 * static_cast<double>(whole_particles));
}

TEST_F(ChunksTest, AnActorIsOneAndItsTrackHasNoJump) {
  const DrivenPath path(log_);
  const std::vector<DriveChunk> chunks = cut(path, {.length_m = 20.0});
  const ChunkSplit parting{path, chunks, 6.0};
  Actor actor;
  actor.name = "car_0";
  actor.size_m = {4.0, 2.0, 1.5};
  const double end_s = log_.sweeps.back().time_end_s;
  for (int k = 0; k <= 60; ++k) {
    KeyPose key;
    key.time_s = end_s * k / 60.0;
    key.world_from_actor = log_.world_from_rig.at(key.time_s);
    actor.track.push_back(key);
  }
  std::vector<ChunkScene> parts(3);
  const std::array<int, 3> particles{3, 7, 5};
  for (std::size_t i = 0; i < parts.size(); ++i) {
    Scene& scene = parts[i].scene;
    scene.camera = GaussianSet(SetKind::kCamera, 0, particles[i] + 2);
    scene.lidar = GaussianSet(SetKind::kLidar, 0, 0);
    scene.camera.actor.assign(static_cast<std::size_t>(particles[i]), 1U);
    scene.camera.actor.resize(static_cast<std::size_t>(particles[i]) + 2, 0U);
    scene.camera.params.setConstant(static_cast<float>(i));
    // Two background particles: all remain, also if several chunks have some.
    const Eigen::Index last = scene.camera.size() - 1;
    scene.camera.mean().row(last) = Eigen::RowVector3f(500.0F, 0.0F, 1.0F);
    scene.camera.mean().row(last - 1) = Eigen::RowVector3f(0.0F, 490.0F, 100.0F * static_cast<float>(i));
    scene.actors = {actor};
    // Each chunk places the car differently in its unobserved part.
    for (KeyPose& key : scene.actors[0].track) {
      const Eigen::Vector3d shift(0.1 * static_cast<double>(i), -0.05 * static_cast<double>(i), 0.0);
      key.shift_m = key.world_from_actor.rotation * shift;
    }
  }
  std::vector<std::size_t> read;
  const auto part = [&](std::size_t i) -> const ChunkScene& {
    read.push_back(i);
    return parts[i];
  };
  const Scene one = merged(parts.size(), part, {actor}, parting);
  EXPECT_EQ(read, (std::vector<std::size_t>{0, 1, 2, 0, 1, 2}));  // one after the other, twice
  ASSERT_EQ(one.actors.size(), 1U);
  EXPECT_EQ(std::count(one.camera.actor.begin(), one.camera.actor.end(), 1U), 7);
  // Each chunk keeps its visibility set of the background.
  ASSERT_EQ(one.visibility_sets.size(), 3U);
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t number = number_of_visibility_set(one, k);
    EXPECT_EQ(std::count(one.camera.actor.begin(), one.camera.actor.end(), number), 2);
    const std::vector<Eigen::Vector3d>& places = one.visibility_sets[k].path_m;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const Eigen::Vector3f in_scene = (places[i] - one.origin).cast<float>();
      EXPECT_EQ(chunk_at(chunks, path.place_nearest(in_scene)), k) << i;
      if (i == 0) continue;
      const double step_m = (places[i] - places[i - 1]).norm();
      EXPECT_GT(step_m, 0.1);
      EXPECT_LT(step_m, 5.6);
    }
    EXPECT_NEAR((places.back() - places.front()).norm(), 20.0, 2.0);
  }
  EXPECT_EQ(std::count(one.camera.actor.begin(), one.camera.actor.end(), 0U), 0);
  for (Eigen::Index i = 0; i < one.camera.size(); ++i) {
    const bool is_car = one.camera.actor[static_cast<std::size_t>(i)] == 1U;
    if (is_car) {
      EXPECT_EQ(one.camera.params(i, kOpacityRow), 1.0F);
    }
  }
  for (const KeyPose& key : one.actors[0].track) {
    const Eigen::Vector3d shift = key.world_from_actor.rotation.conjugate() * key.shift_m;
    EXPECT_NEAR((shift - Eigen::Vector3d(0.1, -0.05, 0.0)).norm(), 0.0, 1e-3) << key.time_s;
    EXPECT_NEAR(key.turn_rad.norm(), 0.0, 1e-6);
  }
}

TEST_F(ChunksTest, FilesHoldWhatMemoryWould) {
  Training remembered(test::device(), log_, options(20.0));
  remembered.run();
  const fs::path file = folder_ / "files.checkpoint";
  Training written(test::device(), log_, options(20.0));
  written.run({}, {file, 0});
  EXPECT_TRUE(fs::exists(chunk_file(file, 2)));
  expect_same(written.scene(), remembered.scene());
  // The result of the training equals it, too.
  const std::size_t views = written.result().support->views.size();
  const SceneFile taken = std::move(written).result();
  expect_same(taken.scene, std::move(remembered).result().scene);
  EXPECT_EQ(taken.training->iterations, 60);
  EXPECT_EQ(taken.support->views.size(), views);
}

TEST_F(ChunksTest, AreAsFewAsFitInMemory) {
  const DrivenPath path(log_);
  const auto plan = [&](std::size_t host, std::size_t device, bool grids = false) {
    TrainingOptions o = options(0.0);
    o.chunks.host_memory_bytes = host;
    o.train.memory_bytes = device;
    if (grids) o.train.appearance.color_grids = ColorGridsOf::kPictures;
    return plan_chunks(test::device(), log_, o, path);
  };
  EXPECT_FALSE(plans_chunks(options(0.0)));
  const ChunkPlan whole = plan(std::size_t{1} << 40U, std::size_t{1} << 40U);
  EXPECT_EQ(whole.count, 1U);
  EXPECT_EQ(whole.length_m, path.length_m());
  // The need increases with the length, so a limit of one byte less cuts the drive.
  const ChunkPlan by_host = plan(whole.host_bytes - 1, 0), by_device = plan(0, whole.device_bytes - 1);
  EXPECT_GT(by_host.count, 1U);
  EXPECT_LE(by_host.host_bytes, whole.host_bytes);
  EXPECT_GT(by_device.count, 1U);
  EXPECT_LT(by_device.device_bytes, whole.device_bytes);
  EXPECT_NEAR(by_device.length_m * static_cast<double>(by_device.count), path.length_m(), 1e-6);
  // The estimate is an upper bound of the device memory of a training of this chunk.
  TrainingOptions o = options(by_device.length_m);
  Training training(test::device(), log_, o);
  training.prepare();
  o.train.appearance.color_grids = ColorGridsOf::kNone;  // as in chunks
  const MemoryNeed need = training_memory(test::device(), log_, training.scene(), o);
  EXPECT_GT(static_cast<double>(by_device.device_bytes), 0.8 * static_cast<double>(need.total));
  EXPECT_LT(static_cast<double>(by_device.device_bytes), 3.0 * static_cast<double>(need.total));
  // The error contains the found and the allowed value and the limiting option.
  expect_error(ErrorKind::kUsage, "allowed 0.000 GB by host_memory_bytes", [&] { plan(1000, 0); });
  expect_error(ErrorKind::kUsage, "20 m of the drive at a time", [&] { plan(1000, 0); });
  expect_error(ErrorKind::kDevice, "allowed 0.000 GB by memory_bytes", [&] { plan(0, 1000); });
  expect_error(ErrorKind::kDevice, "which color_grids keeps in one piece", [&] { plan(0, 1000, true); });
}

TEST_F(ChunksTest, PlannedTheyAreThoseOfTheirLength) {
  TrainingOptions planned = options(0.0);
  const DrivenPath path(log_);
  planned.train.memory_bytes = std::size_t{1} << 40U;
  planned.train.memory_bytes = plan_chunks(test::device(), log_, planned, path).device_bytes - 1;
  Training training(test::device(), log_, planned);
  const fs::path file = folder_ / "planned.checkpoint";
  struct Killed {};
  EXPECT_THROW(training.run(
                   [](const TrainStatus& status) {
                     if (status.iteration > 40) throw Killed();
                   },
                   {file, 10}),
               Killed);
  const ChunkPlan plan = training.report().chunks;
  ASSERT_GT(plan.count, 1U);
  Training resumed(test::device(), log_, planned);
  resumed.resume(file);
  resumed.run();
  Training reported(test::device(), log_, options(plan.length_m));
  reported.run();
  expect_same(resumed.scene(), reported.scene());
}

TEST_F(ChunksTest, RefuseWhatOneWouldTellOtherThanTheNext) {
  const auto refuse = [&](const char* key, TrainingOptions o) {
    expect_error(ErrorKind::kUsage, key, [&] { Training(test::device(), log_, o); });
  };
  TrainingOptions o = options(20.0);
  o.train.length.automatic = true;
  refuse("auto.on: found true, allowed a number of iterations", o);
  o = options(20.0);
  o.train.appearance.color_grids = ColorGridsOf::kPictures;
  refuse("color_grids: found pictures, allowed auto, none", o);
}

}  // namespace
}  // namespace simuli

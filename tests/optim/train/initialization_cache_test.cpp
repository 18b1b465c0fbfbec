// Tests that a cached initialisation equals a new one for the same inputs.
#include "optim/train/initialization_cache.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <optional>
#include <set>

#include "host/device/runtime/disk_cache.hpp"
#include "io/log/camera_mask.hpp"
#include "io/scene/scene_folder.hpp"
#include "optim/train/training.hpp"
#include "tests/io/scratch.hpp"
#include "tests/optim/init/street_with_car.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

/// Sets an environment variable during its lifetime.
class Variable {
 public:
  Variable(const char* name, const std::string& value) : name_(name) {
    if (const char* const before = std::getenv(name)) before_ = before;
    ::setenv(name, value.c_str(), 1);
  }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;
  ~Variable() { before_ ? ::setenv(name_, before_->c_str(), 1) : ::unsetenv(name_); }

 private:
  const char* name_;
  std::optional<std::string> before_;
};

class InitializationCacheTest : public test::StreetWithCar {
 protected:
  [[nodiscard]] Variable own_folder() const { return {"SIMULI_CACHE_DIR", scratch_.path().string()}; }
  [[nodiscard]] std::vector<fs::path> files() const {
    std::vector<fs::path> all;
    for (const auto& entry : fs::directory_iterator(scratch_ / "starts")) all.push_back(entry.path());
    return all;
  }
  /// Returns whether a step was computed, not found in the cache.
  bool made(const Log& log, FrameSelection frames = {}) {
    const Variable own = own_folder();
    bool is_made = false;
    const Log found = InitializationCache(true).get(
        report_,
        "step",
        log,
        log,
        [&](const FrameSelection& read) {
          is_made = true;
          Log out = log;
          out.actors.at(0).name = std::to_string(read.seed);
          return out;
        },
        frames);
    EXPECT_EQ(found.actors.at(0).name, std::to_string(frames.seed));
    return is_made;
  }

  /// Result of a training with this number of iterations, and its reported stages.
  struct Trained {
    SceneFile file;
    TrainingReport report;
    std::set<std::string> stages;
  };
  [[nodiscard]] Trained trained(const TrainingOptions& options, const fs::path& checkpoint = {}) const {
    std::unique_ptr<Training> training;
    {
      const Variable own = own_folder();
      training = std::make_unique<Training>(test::device(), log_, options);
    }
    Trained out;
    const auto tell = [&](const std::string& stage, std::size_t, std::size_t) { out.stages.insert(stage); };
    if (fs::exists(checkpoint)) {
      training->resume(checkpoint, tell);
    } else {
      training->prepare(tell);
    }
    out.report = training->run({}, {checkpoint, checkpoint.empty() ? 0 : 100});
    out.file = training->result();
    return out;
  }
  static TrainingOptions options(int iterations) {
    TrainingOptions o;
    o.init = small(true);
    o.frames.image_scale = 1.0;
    o.inpaint_behind_actors = false;
    o.train.iterations = iterations;
    return o;
  }
  static Packed packed(SceneFile file) {
    Packed out;
    out(file.scene, file.lidars, file.world_from_rig);
    return out;
  }

  const test::Scratch scratch_;
  InitializationReport report_;
};

TEST_F(InitializationCacheTest, StepsAreKnownByAllThatTheyRead) {
  EXPECT_TRUE(made(log_));
  EXPECT_FALSE(made(log_));
  EXPECT_TRUE(made(log_, {.seed = 2}));
  EXPECT_TRUE(made(log_, {.counts_by_sensor = false}));  // not user-settable
  Log other = log_;
  other.sweeps[0].time_end_s = std::nextafter(other.sweeps[0].time_end_s, 1.0);  // less than a nanosecond
  EXPECT_TRUE(made(other));
  other = log_;
  std::get<Lidar>(other.lidars[0].model).rows[3].range_bias = 1e-12;
  EXPECT_TRUE(made(other));
  other = log_;
  other.actors[0].track[0].turn_rad.z() = 1e-9;
  EXPECT_TRUE(made(other));
  other = log_;
  other.cameras[0].rig_from_camera.translation.x() += 0.01;
  EXPECT_TRUE(made(other));
  other = log_;
  auto mask = std::make_shared<CameraMask>();
  mask->hidden = {1};
  other.hidden["camera"] = mask;
  EXPECT_TRUE(made(other));
  const Variable build("SIMULI_TEST_BUILD", "other");
  EXPECT_TRUE(made(log_));
}

TEST_F(InitializationCacheTest, LogsAreKnownByTheirFilesBytesAndNotByWhereTheyLie) {
  EXPECT_TRUE(made(log_));
  fs::copy(log_.folder, scratch_ / "copy.log", fs::copy_options::recursive);
  Log copy = log_;
  copy.folder = scratch_ / "copy.log";
  EXPECT_FALSE(made(copy));
  for (const std::string& name : {copy.images[1].file, copy.sweeps[1].file}) {
    std::fstream file(copy.folder / name, std::ios::in | std::ios::out | std::ios::binary);
    file.seekg(100);
    const int byte = file.get();
    file.seekp(100).put(static_cast<char>(byte ^ 1));
    file.close();
    EXPECT_TRUE(made(copy)) << name;
  }
}

TEST_F(InitializationCacheTest, DamagedFilesAreToldAndMadeAnew) {
  EXPECT_TRUE(made(log_));
  ASSERT_EQ(files().size(), 1U);
  const fs::path file = files().front();
  for (const bool cut : {true, false}) {
    const auto last = static_cast<std::streamoff>(fs::file_size(file) - 1);
    if (cut) fs::resize_file(file, static_cast<std::uintmax_t>(last));
    if (!cut) std::fstream(file, std::ios::in | std::ios::out).seekp(last).put('\x7f');
    report_ = {};
    EXPECT_TRUE(made(log_));
    ASSERT_EQ(report_.damaged.size(), 1U);
    EXPECT_EQ(report_.damaged[0].find(file.string()), 0U) << report_.damaged[0];
    EXPECT_FALSE(made(log_));
  }
}

TEST_F(InitializationCacheTest, WhatWasAskedForLongestAgoGoes) {
  EXPECT_TRUE(made(log_));
  const fs::path first = files().front();
  const auto now = fs::file_time_type::clock::now();
  const fs::path large = scratch_.file("starts/large.start", "");
  fs::resize_file(large, InitializationCache::kMost - 100);  // sparse file without disk usage
  fs::last_write_time(large, now - std::chrono::hours(1));
  fs::last_write_time(first, now - std::chrono::hours(2));
  EXPECT_FALSE(made(log_));
  EXPECT_TRUE(made(log_, {.seed = 2}));
  EXPECT_TRUE(fs::exists(first));
  EXPECT_FALSE(fs::exists(large));
}

TEST_F(InitializationCacheTest, ThatCantBeWrittenIsNoError) {
  static_cast<void>(scratch_.file("starts", "a file"));
  EXPECT_TRUE(made(log_));
  EXPECT_TRUE(made(log_));
  EXPECT_TRUE(report_.damaged.empty());
}

TEST_F(InitializationCacheTest, ATrainingFromAKeptStartMakesTheSameBits) {
  TrainingOptions fresh = options(6);
  fresh.cache_initialization = false;
  const Trained expected = trained(fresh);
  EXPECT_FALSE(fs::exists(scratch_ / "starts"));
  EXPECT_EQ(expected.report.start.saved_s, 0.0);
  EXPECT_TRUE(expected.stages.contains("initialise"));

  TrainingOptions other = options(2);
  other.train.camera.sh *= 2.0;
  EXPECT_TRUE(trained(other).stages.contains("initialise"));
  const fs::path checkpoint = scratch_ / "a.checkpoint";
  const Trained kept = trained(options(6), checkpoint);
  EXPECT_GT(kept.report.start.saved_s, 0.0);
  EXPECT_FALSE(kept.stages.contains("initialise"));
  ASSERT_EQ(kept.file.scene.actors.size(), 1U);
  EXPECT_EQ(packed(kept.file).bytes(), packed(expected.file).bytes());
  EXPECT_EQ(kept.report.init.voxels, expected.report.init.voxels);
  EXPECT_EQ(kept.report.found.moving_returns, expected.report.found.moving_returns);
  EXPECT_EQ(kept.report.path.refined_m, expected.report.path.refined_m);
  EXPECT_GT(kept.report.path.refined_m, 0.0);
  // The origin of the checkpoint makes no difference.
  const Trained longer = trained(options(9), checkpoint);
  EXPECT_FALSE(longer.stages.contains("initialise"));
  fresh.train.iterations = 12;
  const Trained resumed = trained(fresh, checkpoint);
  EXPECT_TRUE(resumed.stages.contains("initialise"));
  EXPECT_EQ(packed(trained(options(12), checkpoint).file).bytes(), packed(resumed.file).bytes());
}

TEST_F(InitializationCacheTest, EachStretchHasItsOwn) {
  TrainingOptions o = options(4);
  o.chunks.length_m = 5.0;
  TrainingOptions fresh = o;
  fresh.cache_initialization = false;
  const Trained expected = trained(fresh);
  ASSERT_GT(expected.file.scene.visibility_sets.size(), 1U);
  EXPECT_EQ(packed(trained(o).file).bytes(), packed(expected.file).bytes());
  const Trained kept = trained(o);
  EXPECT_EQ(packed(kept.file).bytes(), packed(expected.file).bytes());
  EXPECT_FALSE(kept.stages.contains("initialise"));
}

}  // namespace
}  // namespace simuli

// Tests programs that enhance pictures: the protocol, and trainings with enhanced pictures.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <memory>
#include <stdexcept>
#include <thread>

#include "host/core/base/error.hpp"
#include "host/core/base/interruption.hpp"
#include "optim/complete/run_fixer.hpp"
#include "optim/train/trainer.hpp"
#include "optim/train/training.hpp"
#include "tests/host/expect_error.hpp"
#include "tests/optim/small_street.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

std::vector<FixerView> two_views() {
  std::vector<FixerView> views;
  for (const char* name : {"000000", "000001"}) {
    FixerView view{.name = name,
                   .camera = {"front", 8, 4, 6.0, 6.0, 4.0, 2.0},
                   .world_from_camera = {},
                   .rendered = Image(8, 4, 3),
                   .support = Image(8, 4, 1),
                   .recorded = Image(8, 4, 3)};
    std::fill(view.rendered.data.begin(), view.rendered.data.end(), 0.4F);
    views.push_back(std::move(view));
  }
  return views;
}

const std::string kCopy =
    R"(copy() { for f in "$1"/*_support.png; do b=$(basename "$f" _support.png); cp "$1/$b.png" "$2/"; done; }; copy)";

TEST(RunFixer, WhatAProgramCopiesComesBack) {
  const std::vector<Image> mended = run_fixer(kCopy, two_views(), 7);
  ASSERT_EQ(mended.size(), 2U);
  for (const Image& image : mended) {
    EXPECT_EQ(image.width, 8);
    EXPECT_EQ(image.height, 4);
    EXPECT_NEAR(image.data.front(), 0.4F, 1.0F / 255.0F);
  }
}

TEST(RunFixer, IsToldOfItsViewsAndLeavesNoFolderBehind) {
  const fs::path reported = fs::path(testing::TempDir()) / "fixer_was_told";
  (void)run_fixer("keep() { cp \"$1/views.json\" " + reported.string() + "; echo \"$1\" >> " +
                      reported.string() +
                      "; for b in 000000 000001; do cp \"$1/$b.png\" \"$2/\"; done; }; keep",
                  two_views(),
                  7);
  std::ifstream in(reported);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  for (const char* word :
       {"\"simuli fixer\"", "\"iteration\": 7", "000001_support.png", "world_from_camera", "fx_px"})
    EXPECT_NE(text.find(word), std::string::npos) << word;
  std::string folder = text.substr(text.find_last_of('}') + 2);
  folder.pop_back();
  EXPECT_FALSE(fs::exists(folder)) << folder;
  fs::remove(reported);
}

TEST(RunFixer, ProgramsThatFailAreOneLine) {
  const auto refused = [](const std::string& command, const std::string& words) {
    expect_error(ErrorKind::kInput, words, [&] { (void)run_fixer(command, two_views(), 0); });
  };
  refused("exit 3;", "exit code 3");
  refused("/no/such/program", "exit code 127");
  refused("kill -9 $$;", "signal 9");
  refused("true", "no 000000.png");
  refused("gone() { rm -r \"$2\"; }; gone", "no 000000.png");
  refused("gone() { rm -r \"$(dirname \"$2\")\"; }; gone", "no 000000.png");
  refused("file() { rmdir \"$2\"; echo x > \"$2\"; }; file", "no 000000.png");
  refused("some() { cp \"$1/000000.png\" \"$2/\"; }; some", "no 000001.png");
  refused("more() { cp \"$1\"/* \"$2/\"; }; more", "named as those it was given alone");
  refused("junk() { for b in 000000 000001; do echo junk > \"$2/$b.png\"; done; }; junk", "000000.png");
  refused("small() { for b in 000000 000001; do cp \"" +
              (fs::path(testing::TempDir()) / "none.png").string() + "\" \"$2/$b.png\"; done; }; small",
          "exit code 1");
}

TEST(RunFixer, ALostExitCodeIsAnError) {
  const auto before = std::signal(SIGCHLD, SIG_IGN);  // waitpid() fails with ECHILD
  expect_error(ErrorKind::kInput, "found no exit code", [] { (void)run_fixer(kCopy, two_views(), 7); });
  std::signal(SIGCHLD, before);
}

TEST(RunFixer, WhatAProgramPrintsIsNoData) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  (void)run_fixer("echo loading the model...; " + kCopy, two_views(), 7);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "loading the model...\n");
}

TEST(RunFixer, AnInterruptionEndsAllThatItStarted) {
  const fs::path reported = fs::path(testing::TempDir()) / "fixer_interrupted";
  const auto text = [&] {
    std::ifstream in(reported);
    return std::string{std::istreambuf_iterator<char>(in), {}};
  };
  fs::remove(reported);
  const std::function<void()> check = [&] {
    if (text().ends_with('\n')) throw std::runtime_error("interrupted");
  };
  const Interruption interruption(check);
  const std::string command = "sleep 300 & echo $! > " + reported.string() + "; wait;";
  EXPECT_THROW((void)run_fixer(command, two_views(), 0), std::runtime_error);
  // The sleep has received the signal; on a busy machine it ends later.
  const auto is_gone = [stat = "/proc/" + std::to_string(std::stoi(text())) + "/stat"] {
    std::string state;
    std::ifstream(stat) >> state >> state >> state;
    return state.empty() || state == "Z" || state == "X";  // ended, or not yet waited for
  };
  constexpr int kMostLooks = 1000;
  for (int i = 0; i < kMostLooks && !is_gone(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_TRUE(is_gone());
  fs::remove(reported);
}

TEST(RunFixer, PicturesOfAnotherSizeAreRefused) {
  std::vector<FixerView> views = two_views();
  views[1].rendered = Image(8, 5, 3);  // its copy has another size than the camera
  expect_error(ErrorKind::kInput, "8 x 5, allowed 8 x 4", [&] { (void)run_fixer(kCopy, views, 0); });
}

class FixerTest : public test::SmallStreet {
 protected:
  static TrainingOptions options(int iterations, const std::string& command) {
    TrainingOptions o;
    o.frames.image_scale = 1.0;
    o.init.voxel_m = 0.3;
    o.init.sweep_depth = false;
    o.train.iterations = iterations;
    o.train.lidar_every = 2;
    o.fixer.views = 2;
    o.fixer.rounds = 2;
    o.fixer_command = command;
    return o;
  }
  static Scene trained(const TrainingOptions& o) {
    Training training(test::device(), log_, o);
    training.run();
    return training.scene();
  }
};

TEST_F(FixerTest, ChangesTheCameraSetAloneAndAlwaysInTheSameWay) {
  const std::string recorded =
      "take() { for f in \"$1\"/*_recorded.png; do cp \"$f\" \"$2/$(basename \"$f\" _recorded.png).png\"; "
      "done; }; take";
  const Scene without = trained(options(12, ""));
  const Scene with = trained(options(12, recorded));
  EXPECT_NE(with.camera.params, without.camera.params);
  EXPECT_EQ(with.lidar.params, without.lidar.params);
  EXPECT_EQ(trained(options(12, recorded)).camera.params, with.camera.params);
}

TEST_F(FixerTest, GoesOnFromACheckpointWithTheSameBits) {
  const fs::path checkpoint = folder_ / "fixer.checkpoint";
  const TrainingOptions o = options(12, kCopy);
  const auto started = [&] { return std::make_unique<Trainer>(test::device(), log_, initial_scene(), o); };
  const auto whole = started(), first = started(), resumed = started();
  (void)whole->run();
  struct Enough {};
  const auto stop = [](const TrainStatus& status) {
    if (status.iteration == 8) throw Enough();  // the program was called once, and would be called again
  };
  EXPECT_THROW((void)first->run(stop), Enough);
  first->save(checkpoint, "");
  resumed->resume(checkpoint, "");
  (void)resumed->run();
  EXPECT_EQ(resumed->scene().camera.params, whole->scene().camera.params);
}

TEST_F(FixerTest, AnotherProgramIsAnotherTraining) {
  const fs::path checkpoint = folder_ / "program.checkpoint";
  Training first(test::device(), log_, options(4, kCopy));
  first.run([](const TrainStatus&) {}, {.file = checkpoint, .every = 4});
  Training other(test::device(), log_, options(4, "true"));
  EXPECT_THROW(other.resume(checkpoint), Error);
}

TEST_F(FixerTest, AProgramThatFailsEndsTheTraining) {
  expect_error(ErrorKind::kInput, "exit code 4", [&] { (void)trained(options(8, "exit 4;")); });
}

}  // namespace
}  // namespace simuli

// What a training writes: never over what is there, whole or not at all, and a checkpoint when it is stopped.
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <thread>

#include "tests/cli/background_program.hpp"
#include "tests/cli/cli_fixture.hpp"

namespace {

using namespace simuli::test;

constexpr int kInterrupted = 75;
constexpr std::chrono::seconds kUnderWay(1);  // behind the frames that a training is of

class TrainOutputCli : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    make_street("--no-moving-car");
  }
  [[nodiscard]] static std::string train(const std::string& more) {
    return "--json train s.log --iterations 3 --set init.voxel_m=0.3 " + more;
  }
  [[nodiscard]] std::string content(const std::string& file) const {
    std::ifstream in(folder_ / file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  /// Names in the test's folder but for what run() puts there.
  [[nodiscard]] std::set<std::string> names() const {
    std::set<std::string> found;
    for (const auto& entry : fs::directory_iterator(folder_)) found.insert(entry.path().filename().string());
    for (const char* own : {"out.txt", "err.txt", "train.txt", "s.log"}) found.erase(own);
    return found;
  }
  /// A long training with checkpoints.
  [[nodiscard]] std::unique_ptr<BackgroundProgram> start(const std::string& every,
                                                         const std::string& iterations = "100000",
                                                         const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{SIMULI_PROGRAM,
                                       "train",
                                       (folder_ / "s.log").string(),
                                       "-o",
                                       (folder_ / "a.scene").string(),
                                       "--iterations",
                                       iterations,
                                       "--checkpoint-every",
                                       every,
                                       "--set",
                                       "init.voxel_m=0.3"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return std::make_unique<BackgroundProgram>(std::move(arguments), folder_ / "train.txt");
  }
  [[nodiscard]] bool wait_for(const std::string& name) const {
    for (int tries = 0; tries < 600 && !fs::exists(folder_ / name); ++tries) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return fs::exists(folder_ / name);
  }
};

TEST_F(TrainOutputCli, WhatIsThereStaysUnlessToldOtherwise) {
  ASSERT_EQ(run(train("-o a.scene")).exit_code, 0);
  const std::string old = content("a.scene/camera.ply");
  expect_failure(
      train("-o a.scene --seed 2"), kInput, "a.scene: folder: found something of that name, allowed a path");
  expect_failure(train("-o a.scene/ --seed 2"), kInput, "--overwrite");
  expect_failure(train("-o a.scene --seed 2 --resume"), kInput, "its checkpoint, a path");
  EXPECT_EQ(content("a.scene/camera.ply"), old);
  const Outcome again = run(train("-o a.scene --seed 2 --overwrite"));
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_NE(content("a.scene/camera.ply"), old);
  // Somebody's files are never taken for a scene's.
  std::ofstream(folder_ / "a.scene" / "notes.txt") << "mine";
  expect_failure(train("-o a.scene --overwrite"), kInput, "found \"notes.txt\" in it");
  fs::create_directory(folder_ / "empty");
  expect_failure(train("-o empty"), kInput, "found something of that name");
  std::ofstream(folder_ / "file") << "mine";
  expect_failure(train("-o file --overwrite"), kInput, "file: folder: found something else");
  std::ofstream(folder_ / "b.scene.checkpoint") << "of a training that was killed";
  expect_failure(train("-o b.scene"), kInput, "allowed --resume, or --overwrite");
  // Nor is a scene replaced from the start where a checkpoint is asked for that leads nowhere.
  for (const char* to : {"nowhere", "a.scene.checkpoint"}) {
    fs::create_symlink(to, folder_ / "a.scene.checkpoint");
    expect_failure(
        train("-o a.scene --resume"), kInput, "a.scene.checkpoint: file: found something that is no");
    fs::remove(folder_ / "a.scene.checkpoint");
  }
  EXPECT_EQ(names(), (std::set<std::string>{"a.scene", "empty", "file", "b.scene.checkpoint"}));
}

TEST_F(TrainOutputCli, WhatCannotBeWrittenIsSaidFirst) {
  expect_failure(train("-o a.scene --report no/report.html"), kInput, "report.html: folder: found no folder");
  expect_failure(train("-o a.scene --report s.log"), kInput, "s.log: file: found a folder");
  expect_failure(train("-o /proc/a.scene"), kInput, "/proc/a.scene: folder");
  std::ofstream(folder_ / "file") << "mine";
  expect_failure(train("-o file/a.scene"), kInput, "file/a.scene: folder");
  expect_failure(train("-o a.scene --tensorboard file/events"), kInput, "file/events");
  EXPECT_EQ(names(), (std::set<std::string>{"file"}));
}

TEST_F(TrainOutputCli, AFullDiskLeavesTheOldScene) {
  ASSERT_EQ(run(train("-o a.scene")).exit_code, 0);
  const std::string old = content("a.scene/camera.ply");
  // Files of more than some blocks can't be written, as if there were no room.
  const std::string command = fmt::format("cd '{}' && ulimit -f 16 && '{}' {} >out.txt 2>err.txt",
                                          folder_.string(),
                                          SIMULI_PROGRAM,
                                          train("-o a.scene --seed 2 --overwrite"));
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), kInput) << content("err.txt");
  EXPECT_NE(content("err.txt").find("a.scene/camera.ply: content"), std::string::npos) << content("err.txt");
  EXPECT_EQ(content("a.scene/camera.ply"), old);
  EXPECT_EQ(run("info a.scene").exit_code, 0);
  EXPECT_EQ(names(), (std::set<std::string>{"a.scene"}));
}

TEST_F(TrainOutputCli, ADivergedTrainingIsNoScene) {
  constexpr int kNumeric = 6;
  expect_failure("--json train s.log -o a.scene --iterations 40 --set init.voxel_m=0.3 camera.rate.sh=100",
                 kNumeric,
                 "PSNR of the training pictures fell from");
  EXPECT_EQ(names(), (std::set<std::string>{}));
}

TEST_F(TrainOutputCli, OneTrainingAtATime) {
  const auto first = start("1");
  ASSERT_TRUE(wait_for("a.scene.checkpoint")) << first->output();
  const std::string process = fmt::format("found process {}, which makes it", first->process());
  expect_failure(train("-o a.scene"), kInput, process);
  expect_failure(train("-o a.scene --resume"), kInput, process);
  expect_failure(train("-o a.scene --overwrite"), kInput, process);
  // One that is killed keeps nobody out, and leaves nothing that the next one doesn't take away.
  EXPECT_EQ(first->end_by(SIGKILL), -SIGKILL);
  std::ofstream(folder_ / ".a.scene.999999999-6.tmp.checkpoint") << "half a checkpoint";
  expect_failure(train("-o a.scene"), kInput, "allowed --resume, or --overwrite");
  const Outcome next = run(train("-o a.scene --overwrite"));
  EXPECT_EQ(next.exit_code, 0) << next.err;
  EXPECT_EQ(names(), (std::set<std::string>{"a.scene"}));
}

TEST_F(TrainOutputCli, AStoppedTrainingGoesOn) {
  for (const int signal : {SIGTERM, SIGINT}) {
    const auto training = start("1000000");
    ASSERT_GT(training->disoccluded_number("frames to train on: front "), 0) << training->output();
    std::this_thread::sleep_for(kUnderWay);
    EXPECT_EQ(training->end_by(signal), kInterrupted) << training->output();
    EXPECT_NE(training->output().find("--resume goes on from there"), std::string::npos)
        << training->output();
    EXPECT_EQ(names(), (std::set<std::string>{"a.scene.checkpoint"}));
    const Outcome longer =
        run("--json train s.log -o a.scene --iterations 100000 --max-seconds 0.1 --resume --set "
            "init.voxel_m=0.3");
    EXPECT_EQ(longer.exit_code, 0) << longer.err;
    fs::remove_all(folder_ / "a.scene");
    fs::remove(folder_ / "a.scene.checkpoint");
  }
}

// As `simuli train ... 2>&1 | head`, once it trains: each line that nobody reads is a signal.
TEST_F(TrainOutputCli, ATrainingWhoseOutputNobodyReadsKeepsACheckpoint) {
  const Outcome outcome = run_line(fmt::format(
      "(sh -c '\"{}\" --json-progress train s.log -o a.scene --iterations 1000000 --checkpoint-every 1000000 "
      "--set init.voxel_m=0.3 2>&1; echo $? > code' | grep -m 1 '\"task\":\"train\"')",
      program_));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  EXPECT_EQ(content("code"), fmt::format("{}\n", kInterrupted));
  EXPECT_TRUE(names().contains("a.scene.checkpoint"));
}

// The pipe of signals took their place, and an end by a signal that does not exist never came.
TEST_F(TrainOutputCli, AProgramWithoutStandardStreamsEnds) {
  const Outcome outcome = run_line(fmt::format(
      "timeout -k 1 300 sh -c '\"{}\" train s.log -o a.scene --iterations 2 --set init.voxel_m=0.3 "
      "<&- >&- 2>&-'",
      program_));
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_TRUE(names().contains("a.scene"));
}

TEST_F(TrainOutputCli, ASignalDoesNotWaitForAFixer) {
  const std::string folder = folder_.string(), fixer = "sh " + folder + "/mend.sh";
  std::ofstream(folder_ / "mend.sh") << "if [ -e " << folder << "/slow ]; then touch " << folder
                                     << "/begun; sleep 300; fi\n"
                                        "for f in \"$1\"/*_recorded.png; do"
                                        " cp \"$f\" \"$2/$(basename \"$f\" _recorded.png).png\"; done\n";
  const std::string whole =
      "train s.log --iterations 8 --checkpoint-every 100 --set init.voxel_m=0.3 --fixer '" + fixer + "'";
  ASSERT_EQ(run(whole + " -o b.scene").exit_code, 0);
  std::ofstream(folder_ / "slow") << "";
  const auto training = start("100", "8", {"--fixer", fixer});
  ASSERT_TRUE(wait_for("begun")) << training->output();
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(training->end_by(SIGINT), kInterrupted) << training->output();
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(5));  // busy machines
  EXPECT_NE(training->output().find("interrupted at iteration 4 of 8"), std::string::npos)
      << training->output();
  fs::remove(folder_ / "slow");
  const Outcome rest = run(whole + " -o a.scene --resume");
  ASSERT_EQ(rest.exit_code, 0) << rest.err;
  EXPECT_EQ(content("a.scene/camera.ply"), content("b.scene/camera.ply"));
}

TEST_F(TrainOutputCli, SignalsLeaveNothingHalfWritten) {
  // At any time of a checkpoint, which is written after every iteration: the first signal and a second one.
  for (int i = 0; i < 6; ++i) {
    const auto training = start("1");
    ASSERT_TRUE(wait_for("a.scene.checkpoint")) << training->output();
    std::this_thread::sleep_for(std::chrono::milliseconds(7 * i));
    ::kill(training->process(), SIGTERM);
    const int end = training->end_by(SIGTERM);
    EXPECT_TRUE(end == kInterrupted || end == -SIGTERM) << end << training->output();
    EXPECT_EQ(names(), (std::set<std::string>{"a.scene.checkpoint"}));
    fs::remove(folder_ / "a.scene.checkpoint");
  }
  // Without checkpoints the first signal ends it.
  BackgroundProgram training({SIMULI_PROGRAM,
                              "train",
                              (folder_ / "s.log").string(),
                              "-o",
                              (folder_ / "a.scene").string(),
                              "--iterations",
                              "100000",
                              "--set",
                              "init.voxel_m=0.3"},
                             folder_ / "train.txt");
  ASSERT_GT(training.disoccluded_number("frames to train on: front "), 0) << training.output();
  std::this_thread::sleep_for(kUnderWay);
  EXPECT_EQ(training.end_by(SIGTERM), -SIGTERM);
  EXPECT_EQ(names(), (std::set<std::string>{}));
}

}  // namespace

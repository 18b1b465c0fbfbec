// Trainings that are killed, and go on.
#include <chrono>
#include <csignal>
#include <fstream>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "tests/cli/cli_fixture.hpp"

namespace resume_cli_test {

using namespace simuli::test;

class ResumeCli : public Cli {
 protected:
  void make_log() const { make_street("--no-moving-car"); }
  /// Runs "simuli ARGUMENTS" and kills it once it has written `states` states of the scene's checkpoint; true
  /// when it was still running.
  bool run_and_kill(const std::string& arguments, const std::string& scene, int states) const {
    const fs::path checkpoint = folder_ / (scene + ".checkpoint");
    const auto which = [&] {  // each state is a new file
      struct stat file {};
      return ::stat(checkpoint.c_str(), &file) == 0 ? file.st_ino + 1 : 0;
    };
    auto last = which();
    const std::string command = fmt::format(
        "cd '{}' && exec '{}' {} >out.txt 2>err.txt </dev/null", folder_.string(), SIMULI_PROGRAM, arguments);
    const pid_t child = fork();
    if (child == 0) {
      execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
      _exit(127);
    }
    int status = 0;
    while (states > 0) {
      if (waitpid(child, &status, WNOHANG) != 0) return false;
      if (const auto now = which(); now != last) {
        last = now;
        states -= 1;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    kill(child, SIGKILL);
    waitpid(child, &status, 0);
    return WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL;
  }
};

const std::string kTraining =
    "--iterations 60 --checkpoint-every 3 --set init.voxel_m=0.3 --set lidar_every=2 --set densify.epochs=1.5 "
    "--set anchor.weight=0.01";

TEST_F(ResumeCli, KilledTrainingsGiveTheSameScene) {
  make_log();
  const Outcome whole = run("train s.log -o whole.scene " + kTraining);
  ASSERT_EQ(whole.exit_code, 0) << whole.err;
  EXPECT_TRUE(fs::exists(folder_ / "whole.scene.checkpoint"));  // for a longer training

  // From before the first iteration to well into the training: states 0, 1, 3, 6 and 10 of 20.
  for (int states = 0; states < 5; ++states) {
    EXPECT_TRUE(run_and_kill("train s.log -o killed.scene --resume " + kTraining, "killed.scene", states))
        << states;
  }
  EXPECT_FALSE(fs::exists(folder_ / "killed.scene"));
  const Outcome last = run("train s.log -o killed.scene --resume " + kTraining);
  ASSERT_EQ(last.exit_code, 0) << last.err;
  EXPECT_EQ(content("killed.scene"), content("whole.scene"));
  // A finished one has nothing left to do, and gives the same.
  ASSERT_EQ(run("train s.log -o killed.scene --resume " + kTraining).exit_code, 0);
  EXPECT_EQ(content("killed.scene"), content("whole.scene"));
}

TEST_F(ResumeCli, AFinishedTrainingIsMadeLonger) {
  make_log();
  const std::string train = "train s.log -o a.scene --set init.voxel_m=0.3 --json ";
  ASSERT_EQ(run(train + "--iterations 4 --checkpoint-every 100").exit_code, 0);
  const Outcome longer = run(train + "--iterations 6 --resume --checkpoint-every 100");
  ASSERT_EQ(longer.exit_code, 0) << longer.err;
  EXPECT_EQ(longer.err, "");  // not "from the start"
  EXPECT_NE(longer.out.find("\"iterations\": 6"), std::string::npos) << longer.out;
  expect_failure("train s.log -o a.scene --set init.voxel_m=0.3 --resume --iterations 5",
                 kInput,
                 "a.scene.checkpoint: iterations: found a training of 6, allowed of 5 or fewer");
  // Without --checkpoint-every nothing is kept.
  ASSERT_EQ(run(train + "--iterations 6 --resume").exit_code, 0);
  EXPECT_FALSE(fs::exists(folder_ / "a.scene.checkpoint"));
}

TEST_F(ResumeCli, AnotherLogsCheckpointIsRefused) {
  make_log();
  ASSERT_EQ(run("synth street -o other.log --frames 6 --image-width 64 --image-height 36 --lidar-columns 90 "
                "--no-moving-car --speed 9")
                .exit_code,
            0);
  const std::string rest = " -o a.scene --iterations 4 --set init.voxel_m=0.3 --checkpoint-every 2";
  ASSERT_EQ(run("train s.log" + rest).exit_code, 0);
  expect_failure("train other.log --resume" + rest, kInput, "a.scene.checkpoint: settings: found log=");
}

TEST_F(ResumeCli, AnotherTrainingsCheckpointIsRefused) {
  make_log();
  ASSERT_EQ(run("train s.log -o a.scene --iterations 2 --set init.voxel_m=0.3").exit_code, 0);
  EXPECT_FALSE(fs::exists(folder_ / "a.scene.checkpoint"));
  // Killed: the last state stays.
  ASSERT_TRUE(
      run_and_kill("train s.log -o b.scene --iterations 100000 --checkpoint-every 1 --set init.voxel_m=0.3",
                   "b.scene",
                   1));
  const std::string resume = "train s.log -o b.scene --resume --iterations 100000 ";
  expect_failure(resume + "--set init.voxel_m=0.31", kInput, "init.voxel_m=0.3,");
  expect_failure(resume + "--set init.voxel_m=0.3 --seed 2", kInput, "seed=1");
  std::ofstream(folder_ / "b.scene.checkpoint") << "no state";
  expect_failure(resume + "--set init.voxel_m=0.3", kInput, "b.scene.checkpoint");
  const Outcome fresh = run("train s.log -o c.scene --resume --iterations 1 --set init.voxel_m=0.3");
  EXPECT_EQ(fresh.exit_code, 0);
  EXPECT_NE(fresh.err.find("from the start"), std::string::npos) << fresh.err;
}

TEST_F(ResumeCli, TrainingsThatDoNotFitAreRefusedWithNumbers) {
  make_log();
  constexpr int kDevice = 4;
  // Refused once the particles are counted; --json shows no progress before that.
  expect_failure("--json train s.log -o a.scene --iterations 2 --set memory_bytes=1000000",
                 kDevice,
                 "allowed 0.001 GB by memory_bytes");
  const std::string train = "--json train s.log -o a.scene --iterations 2 --set init.voxel_m=0.3 ";
  expect_failure(train + "--device-memory 1MB", kDevice, "allowed 0.001 GB by memory_bytes");
  expect_failure(train + "--host-memory 2MiB", kUsage, "allowed 0.002 GB by host_memory_bytes");
  for (const char* size : {"6XB", "0", "-1GB", "GB", "1e3", "inf"}) {
    expect_failure(train + "--host-memory=" + size, kUsage, std::string("--host-memory: found ") + size);
  }
  EXPECT_FALSE(fs::exists(folder_ / "a.scene"));
}

}  // namespace resume_cli_test

// simuli batch under kill -9: whoever dies whenever, the files at the end are the same.
#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "tests/cli/batch/batch_fixture.hpp"

namespace {

using namespace simuli::test;

class BatchKillCli : public BatchCli {
 protected:
  void SetUp() override {
    BatchCli::SetUp();
    // A training that goes on where it was, what needs it, and pictures.
    write_jobs(R"({"name": "t", "run": ["train", "s.log", "--iterations", 8, "--checkpoint-every", 2,
                                       "--resume", "--set", "init.voxel_m=0.5", "-o", "out/t.scene"]},
                  {"name": "of t", "run": ["render", "out/t.scene", "--sensor", "front", "-o", "out/t"]},
                  {"name": "log", "run": ["render", "s.scene", "--as-log", "-o", "out/again.log"]},
                  {"name": "info", "run": ["info", "out/t.scene", "--json"], "stdout": "out/t.json"},)" +
               renders(16));
  }
  /// Rank `index` of `count`, as a launcher starts it.
  [[nodiscard]] std::unique_ptr<BackgroundProgram> start_rank(int index, int count, bool is_array) const {
    const std::string i = std::to_string(index), n = std::to_string(count);
    const std::vector<std::string> variables =
        is_array ? std::vector<std::string>{"SLURM_ARRAY_TASK_ID=" + i, "SLURM_ARRAY_TASK_COUNT=" + n}
                 : std::vector<std::string>{"OMPI_COMM_WORLD_RANK=" + i, "OMPI_COMM_WORLD_SIZE=" + n};
    return start(variables, {"--json", "batch", "jobs.json"}, "rank" + i + ".txt");
  }
  /// Nothing but outputs and what made them.
  void expect_tidy() const {
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / "out")) {
      const std::string name = entry.path().filename().string();
      EXPECT_FALSE(name.starts_with('.')) << entry.path();
    }
  }
};

TEST_F(BatchKillCli, RanksKilledAtAnyTimeLeaveTheSameFiles) {
  ASSERT_EQ(run("batch jobs.json").exit_code, 0);
  expect_tidy();
  const auto undisturbed = files_in(folder_ / "out");
  EXPECT_GT(undisturbed.size(), 40U);
  fs::remove_all(folder_ / "out");

  std::mt19937 random(7);
  constexpr std::array<int, 3> kRanks{1, 2, 4};
  int killed = 0;
  for (int round = 0; round < 9; ++round) {
    const int count = kRanks[static_cast<std::size_t>(round) % kRanks.size()];
    std::vector<std::unique_ptr<BackgroundProgram>> ranks;
    for (int i = 0; i < count; ++i) ranks.push_back(start_rank(i, count, round % 2 == 1));
    const int signal = round % 3 == 2 ? SIGTERM : SIGKILL;
    for (const auto& rank : ranks) {
      std::this_thread::sleep_for(std::chrono::milliseconds(random() % 250));
      killed += rank->end_by(signal) == -signal ? 1 : 0;
    }
  }
  EXPECT_GT(killed, 0);
  // What was killed lately may have left its temporaries; they go with the job that is made.
  const Outcome last = run("--json batch jobs.json");
  ASSERT_EQ(last.exit_code, 0) << last.err << last.out;
  EXPECT_EQ(files_in(folder_ / "out"), undisturbed);
  expect_tidy();
  EXPECT_EQ(count(states(run("--json batch jobs.json").out), "done"), 20);
}

TEST_F(BatchKillCli, AStoppedTrainingGoesOnOnlyAsTheSameJob) {
  write_jobs(R"({"name": "t", "run": ["train", "s.log", "--iterations", 100000, "--checkpoint-every", 1,
                                     "--resume", "--set", "init.voxel_m=0.5", "-o", "out/t.scene"]})");
  const auto training = start({}, {"batch", "jobs.json"}, "stopped.txt");
  for (int i = 0; i < 600 && !fs::exists(folder_ / "out/t.scene.checkpoint"); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  constexpr int kInterrupted = 75;
  EXPECT_EQ(training->end_by(SIGTERM), kInterrupted) << training->output();
  EXPECT_TRUE(fs::exists(folder_ / "out/t.scene.checkpoint"));
  EXPECT_FALSE(fs::exists(folder_ / "out/t.scene"));
  expect_tidy();
  // The state of another training would be refused.
  write_jobs(R"({"name": "t", "run": ["train", "s.log", "--iterations", 3, "--seed", 9, "--resume", "--set",
                                     "init.voxel_m=0.5", "-o", "out/t.scene"]})");
  const Outcome other = run("batch jobs.json");
  EXPECT_EQ(other.exit_code, 0) << other.out << other.err;
  EXPECT_FALSE(fs::exists(folder_ / "out/t.scene.checkpoint"));
  // Nor is anybody's own state removed.
  fs::remove(folder_ / "out/t.scene.job");
  fs::remove_all(folder_ / "out/t.scene");
  write("out/t.scene.checkpoint", "mine");
  const Outcome mine = run("batch jobs.json");
  EXPECT_EQ(mine.exit_code, kInput) << mine.out;
  EXPECT_EQ(content(folder_ / "out/t.scene.checkpoint"), "mine");
}

TEST_F(BatchKillCli, UnderTheRealMpirun) {
  if (std::system("command -v mpirun >/dev/null 2>&1") != 0) {
    GTEST_SKIP() << "not run: a batch under mpirun, which is not installed";
  }
  const std::string launch = fmt::format(
      "cd '{}' && OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 "
      "OMPI_MCA_rmaps_base_oversubscribe=1 mpirun -n 3 '{}' --json batch jobs.json >mpi.txt 2>mpi_err.txt",
      folder_.string(),
      program_);
  EXPECT_EQ(std::system(launch.c_str()), 0) << content(folder_ / "mpi_err.txt");
  EXPECT_EQ(count(states(content(folder_ / "mpi.txt")), "made"), 20) << content(folder_ / "mpi.txt");
  const auto files = files_in(folder_ / "out");
  fs::remove_all(folder_ / "out");
  ASSERT_EQ(run("batch jobs.json").exit_code, 0);
  EXPECT_EQ(files, files_in(folder_ / "out"));
}

}  // namespace

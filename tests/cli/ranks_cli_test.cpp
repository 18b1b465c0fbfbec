// Trainings that several ranks share: by mpirun, and by one process with several devices.
#include <gtest/gtest.h>

#include "tests/cli/cli_fixture.hpp"

namespace {

using namespace simuli::test;

constexpr int kRanksDiffer = 7;

class RanksCli : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    ASSERT_EQ(run("synth street -o s.log --frames 4 --image-width 48 --image-height 27 --lidar-columns 60 "
                  "--no-moving-car")
                  .exit_code,
              0);
  }
  /// Runs a command through the shell; `{}` is the program.
  Outcome shell(const std::string& command) const {
    return run_line(
        "export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 "
        "POCL_MAX_PTHREAD_COUNT=1 && " +
        fmt::format(fmt::runtime(command), SIMULI_PROGRAM));
  }
};

/// By mpirun, where it and a program that knows MPI are.
class MpiCli : public RanksCli {
 protected:
  void SetUp() override {
    if (std::system("mpirun --version >/dev/null 2>&1") != 0) {
      GTEST_SKIP() << "not run: trainings by mpirun, which is not installed (openmpi-bin)";
    }
    if (!SIMULI_HAS_MPI) GTEST_SKIP() << "not run: trainings by mpirun, of which the program knows nothing";
    RanksCli::SetUp();
  }
};

const std::string kMpi = "mpirun --oversubscribe ";
const std::string kTraining =
    " train s.log --iterations 6 --checkpoint-every 2 --set shards=4 --set init.voxel_m=0.4 --set "
    "densify.epochs=0.3 -o ";

TEST_F(MpiCli, RanksGiveTheBitsOfOneAndGoOnFromEachOther) {
  const Outcome one = shell("'{}'" + kTraining + "one.scene");
  ASSERT_EQ(one.exit_code, 0) << one.err;
  const Outcome two = shell(kMpi + "-n 2 '{}' --json" + kTraining + "two.scene");
  ASSERT_EQ(two.exit_code, 0) << two.err;
  EXPECT_EQ(content("two.scene"), content("one.scene"));
  EXPECT_NE(two.out.find("\"ranks\": 2"), std::string::npos) << two.out;
  EXPECT_EQ(two.out.find("\"gathered_bytes\": 0,"), std::string::npos) << two.out;
  // Behind its first steps it is stopped, and goes on alone.
  const Outcome begun = shell(kMpi + "-n 2 '{}'" + kTraining + "three.scene --max-seconds 0.001");
  ASSERT_EQ(begun.exit_code, 0) << begun.err;
  EXPECT_NE(begun.err.find("stopped after"), std::string::npos) << begun.err;
  EXPECT_NE(content("three.scene"), content("one.scene"));
  const Outcome ended = shell("'{}'" + kTraining + "three.scene --resume");
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_EQ(content("three.scene"), content("one.scene"));
}

TEST_F(MpiCli, RanksThatDifferAreRefusedByName) {
  const auto refused = [&](const std::string& ranks, const std::string& line) {
    const Outcome outcome = shell("mpirun --oversubscribe " + ranks);
    EXPECT_EQ(outcome.exit_code, kRanksDiffer) << outcome.err;
    // mpirun has its own lines behind it, or before.
    const std::size_t place = outcome.err.find("simuli: ");
    EXPECT_EQ(outcome.err.find(line), place) << outcome.err;
    ASSERT_NE(place, std::string::npos) << outcome.err;
    EXPECT_TRUE(place == 0 || outcome.err[place - 1] == '\n') << outcome.err;
    EXPECT_EQ(outcome.err.find("simuli: ", place + 1), std::string::npos) << outcome.err;
    EXPECT_FALSE(fs::exists(folder_ / "a.scene"));
  };
  refused(
      "-n 1 '{0}'" + kTraining + "a.scene : -n 1 -x SIMULI_TEST_BUILD=other '{0}'" + kTraining + "a.scene",
      "simuli: rank 1: build: found ");
  refused("-n 1 '{0}'" + kTraining + "a.scene : -n 1 '{0}'" + kTraining + "a.scene --seed 3",
          "simuli: rank 1: seed: found 3, expected 1 of rank 0");
}

TEST_F(MpiCli, OneFrameAStepTakesOneRank) {
  const Outcome outcome = shell(kMpi + "-n 2 '{}' train s.log --iterations 2 -o a.scene");
  EXPECT_EQ(outcome.exit_code, kUsage) << outcome.err;
  EXPECT_NE(outcome.err.find("simuli: ranks: found 2, allowed up to 1"), std::string::npos) << outcome.err;
}

TEST_F(RanksCli, TwoDevicesOfOneProcessGiveTheBitsOfOne) {
  const Outcome list = shell("env POCL_DEVICES='pthread pthread' '{}' --json devices");
  if (list.out.find("\"index\": 1,") == std::string::npos) {
    GTEST_SKIP() << "not run: a training by two devices, of which the driver makes one";
  }
  const Outcome one = shell("'{}'" + kTraining + "one.scene --device 0");
  ASSERT_EQ(one.exit_code, 0) << one.err;
  const Outcome two =
      shell("env POCL_DEVICES='pthread pthread' '{}' --json" + kTraining + "two.scene --device 0,1");
  ASSERT_EQ(two.exit_code, 0) << two.err;
  EXPECT_NE(two.out.find("\"ranks\": 2"), std::string::npos) << two.out;
  EXPECT_EQ(content("two.scene"), content("one.scene"));
  expect_failure("train s.log -o a.scene --set shards=2 --device 0,99", 4, "99");
  expect_failure("train s.log -o a.scene --device 0,0", kUsage, "ranks: found 2, allowed up to 1");
}

}  // namespace

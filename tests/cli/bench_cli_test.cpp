// simuli bench is another program, beside this one.
#include <gtest/gtest.h>

#include "tests/cli/cli_fixture.hpp"

namespace {

using namespace simuli::test;

class BenchCli : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    program_ = (folder_ / "simuli").string();
    fs::copy_file(SIMULI_PROGRAM, program_);
  }
};

TEST_F(BenchCli, IsRefusedInOneLineWhereItWasNotBuilt) {
  const Outcome outcome = run("bench --stages");
  EXPECT_EQ(outcome.exit_code, kUsage);
  EXPECT_EQ(outcome.err.rfind("simuli: bench: found no /", 0), 0U) << outcome.err;
  EXPECT_NE(outcome.err.find("allowed a build with -D SIMULI_BENCH=ON"), std::string::npos) << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_EQ(run("--help").out.find("bench"), std::string::npos);
  std::ofstream(folder_ / "simuli-bench") << "#!/bin/sh\n";
  EXPECT_NE(run("--help").out.find("bench"), std::string::npos);
}

TEST_F(BenchCli, GetsAllArgumentsAndGivesItsExitCode) {
  const fs::path program = folder_ / "simuli-bench";
  std::ofstream(program) << "#!/bin/sh\nfor word in \"$@\"; do echo \"[$word]\"; done\nexit 7\n";
  fs::permissions(program, fs::perms::owner_all);
  const Outcome outcome = run("--device 'a b' --json bench --table 6 --quality exact --help");
  EXPECT_EQ(outcome.exit_code, 7);
  EXPECT_EQ(outcome.out, "[--device]\n[a b]\n[--json]\n[--table]\n[6]\n[--quality]\n[exact]\n[--help]\n");
  EXPECT_EQ(outcome.err, "");
}

}  // namespace

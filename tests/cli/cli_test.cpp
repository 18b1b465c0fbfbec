// Runs the program and looks at its exit code, stdout and stderr.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <nlohmann/json.hpp>
#include <stdlib.h>
#include <string>
#include <sys/wait.h>

namespace {

namespace fs = std::filesystem;

struct Outcome {
  int exit_code = -1;
  std::string out;
  std::string err;
};

class Cli : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "simuli_cli_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// Runs "simuli ARGUMENTS" through the shell, in the test's folder.
  Outcome run(const std::string& arguments) const {
    const std::string command = fmt::format(
        "cd '{}' && '{}' {} >out.txt 2>err.txt </dev/null", folder_.string(), SIMULI_PROGRAM, arguments);
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read("out.txt"), read("err.txt")};
  }
  /// The run fails with `exit_code` and one line "simuli: ..." on stderr that holds `part`.
  void expect_failure(const std::string& arguments, int exit_code, const std::string& part) const {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, exit_code) << arguments << ": " << outcome.err;
    EXPECT_EQ(outcome.err.rfind("simuli: ", 0), 0U) << arguments << ": " << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1)
        << arguments << ": " << outcome.err;
    EXPECT_NE(outcome.err.find(part), std::string::npos) << arguments << ": " << outcome.err;
    EXPECT_EQ(outcome.out, "") << arguments;
  }

  fs::path folder_;

 private:
  std::string read(const char* name) const {
    std::ifstream file(folder_ / name);
    return {std::istreambuf_iterator<char>(file), {}};
  }
};

constexpr int kUsage = 2;
constexpr int kInput = 3;

TEST_F(Cli, UsageErrorsAreOneLineAndExitWith2) {
  expect_failure("", kUsage, "subcommand");
  expect_failure("fly", kUsage, "fly");
  expect_failure("info", kUsage, "TARGET");
  expect_failure("info generic64 --no-such-option", kUsage, "--no-such-option");
  expect_failure("synth street", kUsage, "--output");
  expect_failure("synth street -o x.log --frames many", kUsage, "--frames");
  expect_failure("import", kUsage, "subcommand");
  expect_failure("info generic64 row", kUsage, "generic64 is a sensor");
}

TEST_F(Cli, QualityThatIsNotBuiltIsRefused) {
  expect_failure("--quality exact info generic64", kUsage, "this version does not have");
  expect_failure("--quality best info generic64", kUsage, "allowed balanced");
  EXPECT_EQ(run("--quality balanced info generic64").exit_code, 0);
}

TEST_F(Cli, HelpAndVersionGoToStdout) {
  const Outcome help = run("--help");
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_NE(help.out.find("--quality"), std::string::npos);
  EXPECT_EQ(help.err, "");
  EXPECT_EQ(run("synth street --help").exit_code, 0);
  EXPECT_EQ(run("--version").out.rfind("simuli ", 0), 0U);
}

TEST_F(Cli, InputErrorsNameWhatWasFoundAndExitWith3) {
  expect_failure("info nowhere.log", kInput, "nowhere.log: folder: found nothing of that name");
  expect_failure("info .", kInput, "neither log.json nor scene.json");
  fs::create_directory(folder_ / "broken.log");
  std::ofstream(folder_ / "broken.log" / "log.json") << "{\"name\": ";
  expect_failure("info broken.log", kInput, "log.json");
  expect_failure("import kitti nowhere -o x.log", kInput, "nowhere");
  EXPECT_FALSE(fs::exists(folder_ / "x.log"));
}

TEST_F(Cli, OutputThatCannotBeWrittenIsAnError) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here: writing to a full stdout is not tested";
  const int status =
      std::system(fmt::format("'{}' info generic64 >/dev/full 2>/dev/null", SIMULI_PROGRAM).c_str());
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), kInput);
}

TEST_F(Cli, InfoOfABuiltInSensor) {
  const Outcome text = run("info generic64");
  EXPECT_EQ(text.exit_code, 0);
  EXPECT_NE(text.out.find("64 rows x 2650 columns"), std::string::npos) << text.out;
  const Outcome json = run("info generic64 --json --verbose");  // global options behind the command
  ASSERT_EQ(json.exit_code, 0);
  const nlohmann::json sensor = nlohmann::json::parse(json.out);
  EXPECT_EQ(sensor.at("rows").size(), 64U);
  EXPECT_EQ(sensor.at("columns"), 2650);
  EXPECT_NE(json.err.find(" s\n"), std::string::npos) << json.err;
}

TEST_F(Cli, InfoOfASensorFileAndOfAMode) {
  const Outcome built_in = run("info hesai_xt32@20 --json");
  ASSERT_EQ(built_in.exit_code, 0) << built_in.err;
  std::ofstream(folder_ / "mine.json") << built_in.out;
  const Outcome file = run("info mine.json --json");
  ASSERT_EQ(file.exit_code, 0) << file.err;
  EXPECT_EQ(file.out, built_in.out);
  const Outcome text = run("info mine.json");
  for (const char* part : {"32 rows x 1000 columns", "20 turns per second", "row firing times", "licence"}) {
    EXPECT_NE(text.out.find(part), std::string::npos) << part << " is missing in " << text.out;
  }
  expect_failure("info hesai_xt32@7", kUsage, "allowed 2000x10");
  expect_failure("info hesai_x32", kInput, "like hesai_xt32");
  std::ofstream(folder_ / "wrong.json") << "{\"kind\": \"lidar\", \"colour\": 1}";
  expect_failure("info wrong.json", kInput, "wrong.json: ");
  EXPECT_NE(run("info sensors").out.find("velodyne_vlp16"), std::string::npos);
}

TEST_F(Cli, SynthesisedLogCanBeLookedAt) {
  const Outcome synth =
      run("synth street -o small.log --frames 2 --image-width 32 --image-height 18 --lidar-columns 36");
  ASSERT_EQ(synth.exit_code, 0) << synth.err;
  EXPECT_EQ(synth.err.find('\r'), std::string::npos);  // no bar where no terminal is
  const Outcome info = run("--json info small.log");
  ASSERT_EQ(info.exit_code, 0) << info.err;
  const nlohmann::json log = nlohmann::json::parse(info.out);
  EXPECT_EQ(log.at("kind"), "log");
  EXPECT_EQ(log.at("images"), 2);
  EXPECT_EQ(log.at("sweeps"), 2);
  ASSERT_FALSE(log.at("sensors").empty());
  for (const auto& sensor : log.at("sensors")) {
    const std::string name = sensor.at("name");
    const Outcome one = run("info small.log " + name + " --json");
    ASSERT_EQ(one.exit_code, 0) << one.err;
    EXPECT_EQ(nlohmann::json::parse(one.out), sensor);
  }
  expect_failure("info small.log rear", kInput, "sensor: found \"rear\"");
  expect_failure("synth street -o small.log", kInput, "small.log");  // never overwritten
}

}  // namespace

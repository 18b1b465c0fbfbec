#pragma once
// Runs the program and looks at its exit code, stdout and stderr.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <map>
#include <stdlib.h>
#include <string>
#include <sys/wait.h>

namespace simuli::test {

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
    return run_line(fmt::format("'{}' {}", program_, arguments));
  }
  /// Runs a line of the shell, in the test's folder.
  Outcome run_line(const std::string& line) const {
    const std::string command =
        fmt::format("cd '{}' && {} >out.txt 2>err.txt </dev/null", folder_.string(), line);
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read("out.txt"), read("err.txt")};
  }
  /// The files of a scene, by name.
  std::map<std::string, std::string> content(const std::string& scene) const {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::directory_iterator(folder_ / scene)) {
      files[entry.path().filename()] = read(entry.path());
    }
    return files;
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
  std::string program_ = SIMULI_PROGRAM;

 private:
  std::string read(const fs::path& name) const {
    std::ifstream file(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
};

inline constexpr int kUsage = 2;
inline constexpr int kInput = 3;

}  // namespace simuli::test

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
#include <unistd.h>

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
  /// s.log: a street of six frames, 64 x 36 pixels and 32 x 90 rays; `more`: arguments of synth.
  void make_street(const std::string& more = "") const {
    make_once(
        "s.log",
        "synth street -o s.log --frames 6 --image-width 64 --image-height 36 --lidar-columns 90 " + more);
  }
  /// That street, and s.scene, trained on it for so many iterations.
  void make_street_scene(int iterations = 1) const {
    make_street();
    make_once("s.scene",
              fmt::format("train s.log -o s.scene --iterations {} --set init.voxel_m=0.3", iterations));
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
  /// The folder `name` by a command that gives the same each time: run once per process, then copied.
  void make_once(const std::string& name, const std::string& command) const {
    static const struct Made {
      fs::path folder = fs::temp_directory_path() / fmt::format("simuli_made_{}", ::getpid());
      ~Made() { fs::remove_all(folder); }
    } made;
    static std::map<std::string, fs::path> places;
    if (const auto found = places.find(command); found != places.end()) {
      fs::copy(found->second, folder_ / name, fs::copy_options::recursive);
      return;
    }
    const Outcome outcome = run(command);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    fs::create_directories(made.folder);
    const fs::path place = made.folder / std::to_string(places.size());
    fs::copy(folder_ / name, place, fs::copy_options::recursive);
    places.emplace(command, place);
  }
  std::string read(const fs::path& name) const {
    std::ifstream file(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
};

inline constexpr int kUsage = 2;
inline constexpr int kInput = 3;

}  // namespace simuli::test

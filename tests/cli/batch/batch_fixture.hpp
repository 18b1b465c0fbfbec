#pragma once
// Folders with a street of a few pixels, its scene, and jobs.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/cli/background_program.hpp"
#include "tests/cli/cli_fixture.hpp"

namespace simuli::test {

class BatchCli : public Cli {
 protected:
  /// s.log and s.scene, made once for all tests of the process.
  void SetUp() override {
    Cli::SetUp();
    struct Made {
      fs::path folder;
      ~Made() { fs::remove_all(folder); }
    };
    static Made made;
    if (made.folder.empty()) {
      std::string pattern = (fs::temp_directory_path() / "simuli_batch_XXXXXX").string();
      ASSERT_NE(mkdtemp(pattern.data()), nullptr);
      ASSERT_EQ(run("synth street -o s.log --frames 3 --image-width 32 --image-height 18 --lidar-columns 60")
                    .exit_code,
                0);
      ASSERT_EQ(run("train s.log -o s.scene --iterations 2 --set init.voxel_m=0.5").exit_code, 0);
      made.folder = pattern;
      for (const char* name : {"s.log", "s.scene"}) fs::rename(folder_ / name, made.folder / name);
    }
    for (const char* name : {"s.log", "s.scene"}) {
      fs::copy(made.folder / name, folder_ / name, fs::copy_options::recursive);
    }
  }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  void write_jobs(const std::string& jobs, const std::string& name = "jobs.json") const {
    write(name, R"({"format": "simuli batch", "version": 1, "jobs": [)" + jobs + "]}");
  }
  /// A picture each: of `count` places beside the lane.
  [[nodiscard]] static std::string renders(int count) {
    std::string jobs;
    for (int i = 0; i < count; ++i) {
      jobs += fmt::format(R"({}{{"name": "r{}", "run": ["render", "s.scene", "--sensor", "front",
                              "--frames", "0:0", "--lane-shift", {}, "-o", "out/r{}"]}})",
                          i > 0 ? ", " : "",
                          i,
                          0.1 * i,
                          i);
    }
    return jobs;
  }

  using States = std::map<std::string, std::string>;
  /// By job, of lines of JSON.
  [[nodiscard]] static States states(const std::string& lines) {
    States states;
    std::istringstream in(lines);
    for (std::string line; std::getline(in, line);) {
      if (!line.starts_with('{')) continue;
      const nlohmann::json told = nlohmann::json::parse(line);
      const bool is_new = states.emplace(told.at("job"), told.at("state")).second;
      EXPECT_TRUE(is_new) << line;
    }
    return states;
  }
  [[nodiscard]] static int count(const States& states, const std::string& state) {
    int found = 0;
    for (const auto& [job, is] : states) found += is == state ? 1 : 0;
    return found;
  }

  [[nodiscard]] static std::string content(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  /// Content by name, of all but records of jobs.
  [[nodiscard]] static std::map<std::string, std::string> files_in(const fs::path& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      if (!entry.is_regular_file() || entry.path().extension() == ".job") continue;
      files[entry.path().lexically_relative(folder).string()] = content(entry.path());
    }
    return files;
  }

  /// Beside the test, in its folder, with variables "A=B".
  [[nodiscard]] std::unique_ptr<BackgroundProgram> start(const std::vector<std::string>& variables,
                                                         const std::vector<std::string>& arguments,
                                                         const std::string& log) const {
    std::vector<std::string> words{"env", "-C", folder_.string()};
    words.insert(words.end(), variables.begin(), variables.end());
    words.push_back(program_);
    words.insert(words.end(), arguments.begin(), arguments.end());
    return std::make_unique<BackgroundProgram>(words, folder_ / log);
  }
};

}  // namespace simuli::test

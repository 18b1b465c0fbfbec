// Logs, scenes and sensors as somebody would make them who wants a file of his on this machine, or one of it.
#include <fstream>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/cli/cli_fixture.hpp"

namespace {

using namespace simuli::test;
using Json = nlohmann::ordered_json;

class HostileCli : public Cli {
 protected:
  /// The test's folder is three levels down, so that what climbs up is found there.
  void SetUp() override {
    Cli::SetUp();
    top_ = folder_;
    folder_ = top_ / "a" / "b" / "c";
    fs::create_directories(folder_);
    make_street_scene();
  }
  void TearDown() override {
    folder_ = top_;
    Cli::TearDown();
  }
  [[nodiscard]] Json read_json(const std::string& file) const {
    std::ifstream in(folder_ / file);
    return Json::parse(in);
  }
  void write_json(const std::string& file, const Json& json) const {
    std::ofstream(folder_ / file) << json.dump();
  }
  /// Everything below the topmost folder but what commands print, and what commands may have put elsewhere.
  [[nodiscard]] std::set<std::string> files() const {
    std::set<std::string> found;
    for (const auto& entry : fs::recursive_directory_iterator(top_)) found.insert(entry.path().string());
    for (const char* file : {"out.txt", "err.txt"}) found.erase((folder_ / file).string());
    for (const char* file : {"/tmp/simuli_hostile_000000.png", "/tmp/simuli_hostile_000000.ply"}) {
      if (fs::exists(file)) found.insert(file);
    }
    return found;
  }
  /// Each command ends with `exit_code` and one line, and leaves no file.
  void refused(const std::vector<std::string>& commands, const std::string& part) const {
    const std::set<std::string> before = files();
    for (const std::string& command : commands) {
      expect_failure(command, kInput, part);
      EXPECT_EQ(files(), before) << command;
    }
  }

  fs::path top_;
};

const std::vector<std::string> kNames{"../../x",
                                      "../../../x",
                                      "/tmp/simuli_hostile",
                                      "..",
                                      ".x",
                                      "a/b",
                                      "a\\b",
                                      "a\nb",
                                      "",
                                      std::string(200, 'x')};

/// Where they stand, in logs and scenes.
const std::vector<std::string> kPlaces{"/cameras/0/name", "/lidars/0/name", "/actors/0/name"};

TEST_F(HostileCli, NamesOfScenesWriteNothing) {
  const Json scene = read_json("s.scene/scene.json");
  std::size_t count = 0;
  for (const std::string& name : kNames) {
    Json changed = scene;
    changed[Json::json_pointer(kPlaces[count++ % kPlaces.size()])] = name;
    write_json("s.scene/scene.json", changed);
    refused({"render s.scene --sensor '" + (name.empty() ? "front" : name) + "' --times 0:0:1 -o out"},
            "name");
  }
  // The other commands that read scenes, with one of them.
  Json changed = scene;
  changed["cameras"][0]["name"] = kNames.front();
  write_json("s.scene/scene.json", changed);
  refused({"eval s.scene s.log --report eval.html",
           "export s.scene -o out.ply",
           "view s.scene --port 0",
           "info s.scene",
           "render s.scene --sensor top --add s.scene:car:guest -o out"},
          "");
}

TEST_F(HostileCli, NamesOfLogsWriteNothing) {
  const Json log = read_json("s.log/log.json");
  std::size_t count = 1;
  for (const std::string& name : kNames) {
    Json changed = log;
    changed[Json::json_pointer(kPlaces[count++ % kPlaces.size()])] = name;
    write_json("s.log/log.json", changed);
    refused({"info s.log"}, "name");
  }
  refused({"train s.log -o out.scene",
           "eval s.scene s.log",
           "actors s.log -o out.log",
           "render s.scene --sensor top --trajectory s.log -o out"},
          "name");
}

TEST_F(HostileCli, SensorFilesWriteNothing) {
  const Json sensor = Json::parse(run("info generic64 --json").out);
  for (const std::string& name : kNames) {
    Json changed = sensor;
    changed["name"] = name;
    write_json("mine.json", changed);
    refused({"info mine.json"}, "name");
  }
  refused({"render s.scene --sensor mine.json --times 0:0:1 -o out"}, "name");
}

TEST_F(HostileCli, LinksThatLeadOutAreNotFollowed) {
  std::ofstream(top_ / "secret") << "of somebody else";
  const fs::path picture = folder_ / "s.log" / read_json("s.log/log.json")["images"][0]["file"];
  fs::remove(picture);
  fs::create_symlink(top_ / "secret", picture);
  refused({"info s.log", "train s.log -o out.scene", "actors s.log -o out.log"}, "a link that leads out");
  fs::remove(folder_ / "s.scene" / "camera.ply");
  fs::create_symlink(top_ / "secret", folder_ / "s.scene" / "camera.ply");
  refused({"info s.scene", "render s.scene --sensor front -o out"}, "a link that leads out");
  fs::remove(folder_ / "s.log" / "log.json");
  fs::create_symlink(top_ / "secret", folder_ / "s.log" / "log.json");
  refused({"train s.log -o out.scene"}, "a link that leads out");
  std::ofstream(folder_ / "transforms.json")
      << R"({"w": 8, "h": 6, "fl_x": 8, "frames": [{"file_path": "../../../secret.png", "transform_matrix":
             [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]})";
  refused({"import nerfstudio transforms.json -o out.log"}, "file_path");
}

TEST_F(HostileCli, RefusalsAreOneLine) {
  Json log = read_json("s.log/log.json");
  log["images"][0]["file"] = "\u202egnp.\u0085";
  write_json("s.log/log.json", log);
  refused({"info s.log", "train s.log -o out.scene"}, "found \"\\xe2\\x80\\xaegnp.\\xc2\\x85\"");
  // Particles of actors that would have been left out are no news where nothing was written.
  refused({"export s.scene -o out.splat"}, "found \".splat\", allowed .ply, .spz, .glb, .usda or .usdz");
  fs::copy(folder_ / "s.scene" / "camera.ply", folder_ / "0.png");
  std::ofstream(folder_ / "transforms.json")
      << R"({"w": 8, "h": 6, "fl_x": 8, "frames": [{"file_path": "0.png", "transform_matrix":
             [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]})";
  expect_failure(
      "import nerfstudio transforms.json -o ''", kUsage, "--output: found nothing, allowed a text");
}

TEST_F(HostileCli, PathsAreToldOnOneLineAndWithoutEscapes) {
  const std::string name = "'a\x1b[2J\nb\u202e'\\''c'";  // as sh reads it
  const auto reported = [&](std::string command) {
    for (std::size_t at = 0; (at = command.find('@', at)) != std::string::npos;) command.replace(at, 1, name);
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.exit_code, 0) << command << outcome.err;
    for (const char* raw : {"\x1b", "\nb", "\u202e"}) {
      EXPECT_EQ(outcome.out.find(raw), std::string::npos) << command << '\n' << outcome.out;
      EXPECT_EQ(outcome.err.find(raw), std::string::npos) << command << '\n' << outcome.err;
    }
    EXPECT_NE(outcome.out.find("[2J"), std::string::npos) << command << '\n' << outcome.out;
    return outcome.out;
  };
  for (const char* command : {"export s.scene -o @.ply",
                              "export s.scene --drive -o @.usdz",
                              "info @.ply",
                              "info @.ply --json",
                              "import splat @.ply -o @.scene",
                              "actors s.log -o @.log",
                              "render s.scene --sensor front --frames 0:1 -o @"}) {
    (void)reported(command);
  }
  // What is to be typed next means that scene.
  const std::string next = reported("train s.log -o @.0.scene --iterations 1 --set init.voxel_m=0.3");
  const std::size_t from = next.find("simuli view ") + 12;
  std::ofstream(folder_ / "next.sh") << "test -d " << next.substr(from, next.find('\n', from) - from);
  EXPECT_EQ(run_line("bash next.sh").exit_code, 0) << next;
}

TEST_F(HostileCli, FilesOfLogsAndScenesAreNotReplaced) {
  const Json log = read_json("s.log/log.json");
  const auto scene = content("s.scene");
  refused({"eval s.scene s.log --report s.log/log.json",
           "train s.log -o t.scene --report s.log/log.json",
           "fit lens tum_vi_cam0 --model ftheta_angle_to_radius -o s.log/log.json",
           "export s.scene -o s.scene/camera.ply"},
          "a new path, or elsewhere");
  EXPECT_EQ(read_json("s.log/log.json"), log);
  EXPECT_TRUE(content("s.scene") == scene);
  std::ofstream(folder_ / "s.log" / "eval.html") << "of yesterday";
  EXPECT_EQ(run("eval s.scene s.log --report s.log/eval.html").exit_code, 0);
  EXPECT_GT(fs::file_size(folder_ / "s.log" / "eval.html"), 1000U);
}

TEST_F(HostileCli, DeepJsonIsRefused) {
  fs::create_directory(folder_ / "deep.log");
  std::ofstream(folder_ / "deep.log" / "log.json") << std::string(200'000, '[');
  fs::create_directory(folder_ / "deep.scene");
  std::ofstream(folder_ / "deep.scene" / "scene.json")
      << "{\"format\": " << std::string(100'000, '[') << std::string(100'000, ']') << '}';
  refused({"info deep.log", "train deep.log -o out.scene", "info deep.scene"}, "found more than 64 levels");
}

}  // namespace

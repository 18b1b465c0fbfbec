// What `simuli info` tells of logs, scenes, splats and sensors, and what it answers to names that it doesn't
// know.
#include <fstream>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/cli/cli_fixture.hpp"

namespace info_cli_test {

using namespace simuli::test;
using nlohmann::json;

class InfoCli : public Cli {
 protected:
  json reported(const std::string& arguments) const {
    const Outcome outcome = run("info " + arguments + " --json");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return json::parse(outcome.out);
  }
  void expect_text(const std::string& arguments, const std::vector<std::string>& parts) const {
    const Outcome outcome = run("info " + arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    for (const std::string& part : parts) {
      EXPECT_NE(outcome.out.find(part), std::string::npos) << part << " is missing in\n" << outcome.out;
    }
  }
};

/// Of terminals, of lines, and of the direction of text.
void spoil_texts(json& value, int& spoilt) {
  constexpr const char* kText = "\x1b]0;title\x07\x1b[2Jx\nsecond\x7f\xc2\x9b\xe2\x80\xae\xe2\x81\xa6";
  for (auto& [key, inner] : value.items()) {
    const bool is_name = key == "name" && !value.contains("hash");  // others are refused
    if (inner.is_string() && !is_name && key != "format" && key != "sensor") {
      inner = kText;
      ++spoilt;
    }
    if (inner.is_structured()) spoil_texts(inner, spoilt);
  }
}

TEST_F(InfoCli, TextsOfFilesAreShownOnOneLineAndWithoutEscapes) {
  make_street();
  ASSERT_EQ(run("train s.log -o s.scene --iterations 1 --set init.voxel_m=0.3").exit_code, 0);
  const auto spoil = [&](const fs::path& file, const std::string& part) {
    json root = json::parse(std::ifstream(file));
    int spoilt = 0;
    spoil_texts(root.at(part), spoilt);
    std::ofstream(file) << root;
    return spoilt;
  };
  EXPECT_GE(spoil(folder_ / "s.scene" / "scene.json", "training"), 7);
  EXPECT_GE(spoil(folder_ / "s.scene" / "scene.json", "actors"), 1);
  EXPECT_GE(spoil(folder_ / "s.log" / "log.json", "actors"), 1);
  for (const std::string command :
       {"info s.scene", "info s.log", "info s.scene --json", "eval s.scene s.log"}) {
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.exit_code, 0) << command << outcome.err;
    const std::string all = outcome.out + outcome.err;
    for (const char* const raw :
         {"\x1b", "\x07", "\x7f", "\xc2\x9b", "\xe2\x80\xae", "\xe2\x81\xa6", "\nsecond"}) {
      EXPECT_EQ(all.find(raw), std::string::npos) << command << '\n' << all;
    }
    EXPECT_NE(all.find("x0asecond"), std::string::npos) << command << '\n' << all;
  }
}

TEST_F(InfoCli, TellsWhatWasRecordedWhenAndWhoWasNear) {
  make_street();
  const json log = reported("s.log");
  ASSERT_EQ(log.at("recorded_frames").size(), 2U);
  for (const json& sensor : log.at("recorded_frames")) {
    EXPECT_EQ(sensor.at("frames"), 6);
    EXPECT_NEAR(sensor.at("rate_hz").get<double>(), 10.0, 1e-6);
    EXPECT_NEAR(sensor.at("end_s").get<double>() - sensor.at("start_s").get<double>(), 0.5, 0.11);
  }
  const json& car = log.at("actors").at(0);
  EXPECT_EQ(car.at("images"), 6);
  EXPECT_EQ(car.at("sweeps"), 6);
  EXPECT_GT(car.at("poses"), 1);
  // It drives on the other lane, some metres away.
  EXPECT_GT(car.at("nearest_m").get<double>(), 2.0);
  EXPECT_LT(car.at("nearest_m").get<double>(), 60.0);
  EXPECT_GE(car.at("nearest_s").get<double>(), 0.0);
  expect_text(
      "s.log",
      {"\n    6 frames, 10.0 per second, ", " deg, focal ", "(6 images, 6 sweeps), travels ", ", nearest "});

  ASSERT_EQ(
      run("train s.log -o s.scene --iterations 1 --set init.voxel_m=0.3 actors.track.learn=true").exit_code,
      0);
  const json scene = reported("s.scene");
  EXPECT_NEAR(scene.at("actors").at(0).at("nearest_m").get<double>(), car.at("nearest_m").get<double>(), 1.0);
  EXPECT_FALSE(scene.at("actors").at(0).contains("images"));  // those are the log's
  EXPECT_EQ(scene.at("recorded_frames"), log.at("recorded_frames"));
  expect_text("s.scene",
              {"\n    6 frames, 10.0 per second, ",
               "settings         actors.track.learn=true init.voxel_m=0.3\n",
               ", nearest "});

  expect_failure("render s.scene --sensor front --remove Carr -o p", kUsage, "found \"Carr\", allowed car");
  expect_failure(
      "render s.scene --sensor frnt -o p", kUsage, "did you mean front? allowed front, top, those that");
  expect_failure(
      "render s.scene --sensor nope -o p", kUsage, "found \"nope\", allowed front, top, those that");

  ASSERT_EQ(run("export s.scene -o s.ply").exit_code, 0);
  ASSERT_EQ(run("export s.scene -o s.spz").exit_code, 0);
  for (const std::string file : {"s.ply", "s.spz", "s.scene/camera.ply"}) {
    const json splats = reported(file);
    EXPECT_EQ(splats.at("kind"), "splats");
    EXPECT_GT(splats.at("particles"), 100);
    EXPECT_EQ(splats.at("mean_min_m").size(), 3U);
    expect_text(file, {"splats " + file, " particles, SH degree ", "in its own units"});
  }
  std::ofstream(folder_ / "broken.ply") << "plywood";
  expect_failure("info broken.ply", kInput, "broken.ply");
  expect_failure("info absent.spz", kInput, "absent.spz");
}

TEST_F(InfoCli, TellsWhatBuiltInCamerasSee) {
  expect_text(
      "sensors",
      {"camera tum_vi_cam0      opencv_fisheye, 512 x 512 px, view ", " deg, focal ", "shutter global"});
  const json sensors = reported("sensors");
  ASSERT_EQ(sensors.at("models").size(), sensors.at("cameras").size() + sensors.at("lidars").size());
  const json& camera = sensors.at("models").at(0);
  EXPECT_EQ(camera.at("name"), sensors.at("cameras").at(0));
  EXPECT_GT(camera.at("view_horizontal_deg"), 10.0);
  const json& lidar = sensors.at("models").back();
  EXPECT_EQ(lidar.at("name"), sensors.at("lidars").back());
  EXPECT_GT(lidar.at("turns_per_s"), 1.0);
}

TEST_F(InfoCli, NearestNamesAnswerTypingErrors) {
  expect_failure("trian s.log", kUsage, "found \"trian\", did you mean train? allowed actors, ");
  expect_failure(
      "train x -o y --iteration 5", kUsage, "found option \"--iteration\", did you mean --iterations?");
  expect_failure("import kiti x", kUsage, "did you mean kitti? allowed kitti, kitti360, ");
  expect_failure("import", kUsage, "found no command, allowed kitti, ");
  expect_failure("info nope",
                 kInput,
                 "nothing of that name, allowed a log, a scene, a splat or sensor file, or a sensor of");
  expect_failure("info hesia_xt32", kInput, "a sensor like hesai_xt32");
  expect_failure("info sensor", kInput, "a sensor like sensors");
}

TEST_F(InfoCli, HelpOfCommandsHasTheOptionsOfAll) {
  const Outcome help = run("train --help");
  EXPECT_EQ(help.exit_code, 0);
  const std::size_t shared = help.out.find("Options of every command:");
  ASSERT_NE(shared, std::string::npos) << help.out;
  for (const char* option : {"--device", "--quality", "--json"}) {
    EXPECT_NE(help.out.find(option, shared), std::string::npos) << option;
  }
}

}  // namespace info_cli_test

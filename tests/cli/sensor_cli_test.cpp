// Sensors from files, as commands take them.
#include <fstream>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/base/file.hpp"
#include "tests/cli/cli_fixture.hpp"

namespace {

using namespace simuli::test;

TEST_F(Cli, CamerasOfFilesAreRendered) {
  make_street_scene();
  // The log's own camera, from a file: the same picture, at another size and with a read-out of its own.
  const auto picture = [&](const std::string& sensor, const std::string& options, const std::string& to) {
    const Outcome seen =
        run("render s.scene --sensor " + sensor + " --times 0.1:0.1:1 " + options + " -o " + to);
    EXPECT_EQ(seen.exit_code, 0) << seen.err;
    return simuli::read_file(folder_ / to / (sensor.substr(0, sensor.find('.')) + "_000000.png"));
  };
  nlohmann::json mine = nlohmann::json::parse(run("info s.scene front --json").out);
  std::ofstream(folder_ / "mine.json") << mine.dump();
  EXPECT_EQ(picture("mine.json", "", "mine"), picture("front", "", "front"));
  mine["shutter"] = "top_to_bottom";
  mine["readout_s"] = 0.1;
  std::ofstream(folder_ / "rolling.json") << mine.dump();
  const std::string rolling = picture("rolling.json", "", "rolling");
  EXPECT_NE(rolling, picture("front", "", "front_again"));
  EXPECT_EQ(rolling, picture("rolling.json", "--duration 0.1", "rolling_again"));
}

TEST_F(Cli, SensorsAreMountedAndSizedAsAsked) {
  make_street_scene();
  const auto render = [&](const std::string& options, const std::string& to) {
    const Outcome seen = run("render s.scene --times 0.1:0.1:1 " + options + " -o " + to);
    EXPECT_EQ(seen.exit_code, 0) << seen.err;
    return nlohmann::json::parse(simuli::read_file(folder_ / to / "frames.json"));
  };
  const auto same = [&](const std::string& a, const std::string& b) {
    return simuli::read_file(folder_ / a) == simuli::read_file(folder_ / b);
  };
  // Where the street's camera and LiDAR are: nothing changes.
  const std::string reported = run("info s.scene").out;
  EXPECT_NE(reported.find("shutter global, mounted at 1.4,0.05,1.5,0,0,0 (m, deg)\n"), std::string::npos)
      << reported;
  EXPECT_NE(reported.find("mounted at 0,0,1.9,0,0,0 (m, deg)\n"), std::string::npos) << reported;
  (void)render("--sensor front", "front");
  const auto mounted = render("--sensor front --mount 1.4,0.05,1.5,0,0,0", "mounted");
  EXPECT_TRUE(same("front/front_000000.png", "mounted/front_000000.png"));
  EXPECT_EQ(mounted.at("edits"), nlohmann::json({"--mount 1.4,0.05,1.5,0,0,0"}));
  (void)render("--sensor top", "top");
  (void)render("--sensor top --mount 0,0,1.9,0,0,0", "top_mounted");
  EXPECT_TRUE(same("top/top_000000.ply", "top_mounted/top_000000.ply"));
  // Elsewhere: a built-in one, that of a file; to the left and 2 m up, the rig moved aside, too.
  (void)render("--sensor top --mount -1,0,2,0,0,90", "turned");
  EXPECT_FALSE(same("top/top_000000.ply", "turned/top_000000.ply"));
  const auto left = render("--sensor tum_vi_cam0 --mount -1,0.5,2,0,0,90 --lane-shift 1", "left");
  EXPECT_EQ(left.at("rig_from_sensor").at("position_m"), nlohmann::json({-1.0, 1.5, 2.0}));
  const auto& q = left.at("rig_from_sensor").at("rotation_wxyz");  // its z is the rig's y
  const double w = q.at(0), x = q.at(1), y = q.at(2), z = q.at(3);
  EXPECT_NEAR(2.0 * (y * z - w * x), 1.0, 1e-9);
  std::ofstream(folder_ / "mine.json") << run("info s.scene front --json").out;
  (void)render("--sensor mine.json --mount 1.4,0.05,1.5,0,0,0", "mine");
  EXPECT_TRUE(same("front/front_000000.png", "mine/mine_000000.png"));
  // Any size.
  const auto small = render("--sensor front --size 32x10", "small").at("sensor");
  EXPECT_EQ(small.at("width_px"), 32);
  EXPECT_EQ(small.at("height_px"), 10);
  EXPECT_NEAR(small.at("fx_px").get<double>() / mounted.at("sensor").at("fx_px").get<double>(), 0.5, 1e-12);
  EXPECT_NEAR(
      small.at("fy_px").get<double>() / mounted.at("sensor").at("fy_px").get<double>(), 10.0 / 36.0, 1e-12);
  EXPECT_EQ(render("--sensor front --scale 2.5", "large").at("sensor").at("width_px"), 160);
  expect_failure("render s.scene --sensor front --scale 0 -o x", kUsage, "half a pixel");
  expect_failure("render s.scene --sensor front --scale 1e-9 -o x", kUsage, "half a pixel");
  expect_failure("render s.scene --sensor front --scale 1e9 -o x", kUsage, "up to 65536 pixels a side");
  expect_failure("render s.scene --sensor front --size 64 -o x", kUsage, "2 finite numbers separated by 'x'");
  expect_failure("render s.scene --sensor front --size 0x9 -o x", kUsage, "whole pixels from 1");
  expect_failure("render s.scene --sensor front --size 9x9 --scale 2 -o x", kUsage, "--size");
  expect_failure("render s.scene --sensor top --size 9x9 -o x", kUsage, "allowed with cameras");
  expect_failure("render s.scene --sensor front --mount 1,2,3 -o x", kUsage, "X,Y,Z,ROLL,PITCH,YAW");
}

}  // namespace

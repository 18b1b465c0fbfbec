// Several sensors in one go.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <string>

#include "io/base/file.hpp"
#include "tests/cli/cli_fixture.hpp"

namespace simuli {
namespace rig_cli_test {

using namespace simuli::test;
using nlohmann::json;

class RigCli : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    make_street_scene();
  }
  void write_rig(const json& sensors) const {
    const json rig = {{"format", "simuli rig"}, {"version", 1}, {"sensors", sensors}};
    write_file_atomically(folder_ / "rig.json", rig.dump());
  }
  void render(const std::string& arguments) const {
    const Outcome done = run("render s.scene " + arguments);
    EXPECT_EQ(done.exit_code, 0) << done.err;
  }
  void expect_same(const std::string& a, const std::string& b) const {
    EXPECT_EQ(read_file(folder_ / a), read_file(folder_ / b)) << a << ", " << b;
  }
};

TEST_F(RigCli, EverySensorIsRenderedAsIfAlone) {
  const json mount = {{"position_m", {1.0, 0.5, 2.0}}, {"pitch_deg", 5}, {"yaw_deg", 30}};
  write_rig({{{"name", "ahead"}, {"sensor", "front"}},
             {{"name", "side"}, {"sensor", "front"}, {"mount", mount}, {"width_px", 40}, {"height_px", 30}},
             {{"name", "roof"}, {"sensor", "velodyne_vlp16@20"}, {"mount", mount}}});
  render("--rig rig.json --frames 1:2 -o all");
  render("--sensor front --frames 1:2 -o ahead");
  render("--sensor front --frames 1:2 --mount 1,0.5,2,0,5,30 --size 40x30 -o side");
  render("--sensor velodyne_vlp16@20 --frames 1:2 --mount 1,0.5,2,0,5,30 -o roof");
  for (const char* i : {"1", "2"}) {
    expect_same(std::string("all/ahead/ahead_00000") + i + ".png",
                std::string("ahead/front_00000") + i + ".png");
    expect_same(std::string("all/side/side_00000") + i + ".png",
                std::string("side/front_00000") + i + ".png");
    expect_same(std::string("all/roof/roof_00000") + i + ".ply",
                std::string("roof/velodyne_vlp16@20_00000") + i + ".ply");
  }
  // A folder of one sensor is what it is without the others.
  json of_all = json::parse(read_file(folder_ / "all/roof/frames.json"));
  json alone = json::parse(read_file(folder_ / "roof/frames.json"));
  EXPECT_EQ(of_all.at("rig_from_sensor"), alone.at("rig_from_sensor"));
  EXPECT_EQ(of_all.at("sensor"), alone.at("sensor"));
  EXPECT_EQ(of_all.at("frames").at(0).at("files").at(0), "roof_000001.ply");
  EXPECT_EQ(of_all.at("frames").at(0).at("time_end_s"), alone.at("frames").at(0).at("time_end_s"));
}

TEST_F(RigCli, SensorsCanBeNamedOneAfterTheOther) {
  const Outcome done = run("render --sensor front --sensor top s.scene --frames 0:0 -o both --json");
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const json reported = json::parse(done.out);
  ASSERT_EQ(reported.at("sensors").size(), 2U);
  EXPECT_EQ(reported.at("sensors").at(1).at("folder"), "both/top");
  EXPECT_EQ(reported.at("sensors").at(1).at("frames"), 1);
  EXPECT_TRUE(fs::exists(folder_ / "both/front/front_000000.png"));
  EXPECT_TRUE(fs::exists(folder_ / "both/top/top_000000.ply"));
  EXPECT_TRUE(fs::exists(folder_ / "both/top/frames.json"));
}

TEST_F(RigCli, BadRequestsAreRefused) {
  write_rig({{{"name", "a"}, {"sensor", "front"}}, {{"name", "b"}, {"sensor", "nobody"}}});
  expect_failure("render s.scene --rig rig.json -o x", kInput, "rig.json: sensors[1].sensor");
  write_rig({{{"name", "a"}, {"sensor", "front"}}});
  expect_failure("render s.scene --rig rig.json --sensor front -o x", kUsage, "--sensor");
  expect_failure("render s.scene --rig rig.json --mount 0,0,0,0,0,0 -o x", kUsage, "--mount");
  expect_failure("render s.scene --rig rig.json --frames 5:6 -o x", kUsage, "a:b with 0 <= a <= b < 6");
  expect_failure("render s.scene --sensor front --sensor front -o x", kUsage, "each name once");
  expect_failure("render s.scene --sensor front --sensor top -o x.mp4", kUsage, "for 2 sensors");
  expect_failure(
      "render s.scene --sensor front --sensor top --mount 0,0,0,0,0,0 -o x", kUsage, "with one --sensor");
  EXPECT_FALSE(fs::exists(folder_ / "x"));
}

}  // namespace rig_cli_test
}  // namespace simuli

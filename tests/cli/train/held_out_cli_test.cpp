// What train holds out, and how eval tells it apart.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/base/file.hpp"
#include "optim/eval/evaluation.hpp"
#include "tests/cli/cli_fixture.hpp"

namespace {

using namespace simuli::test;

class HeldOutCli : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    make_street("--no-moving-car");
  }
};

TEST_F(HeldOutCli, TheEndOfThePathIsHeldOutAndToldApart) {
  const std::string rule = "--held-out 3 --held-out-last 0.3 --iterations 1 --set init.voxel_m=0.3";
  ASSERT_EQ(run("train s.log -o end.scene " + rule).exit_code, 0);
  const Outcome text = run("eval end.scene s.log --report end.html");
  EXPECT_EQ(text.out.rfind("held-out frames: 3 pictures", 0), 0U) << text.out;
  EXPECT_NE(text.out.find("between training frames              1 + 1"), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("at the end of the path               2 + 2"), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("by range"), std::string::npos) << text.out;
  const std::string html = simuli::read_file(folder_ / "end.html");
  EXPECT_NE(html.find("at the end of the path"), std::string::npos);
  const nlohmann::json both = nlohmann::json::parse(run("eval end.scene s.log --json").out);
  EXPECT_EQ(both.at("held_out_last"), 0.3);
  EXPECT_EQ(both.at("between").at("images"), 1);
  EXPECT_EQ(both.at("beyond").at("images"), 2);
  EXPECT_EQ(both.at("ranges").size(), simuli::RangeScores::kFrom_m.size());
  const auto end = nlohmann::json::parse(run("eval end.scene s.log --held-out-last 0.3 --json").out);
  EXPECT_EQ(end.at("psnr_db"), both.at("beyond").at("psnr_db"));
  EXPECT_EQ(end.at("distance_median_m"), both.at("beyond").at("distance_median_m"));
  EXPECT_TRUE(end.at("beyond").is_null());  // all that is compared is of one use
  const std::string info = run("info end.scene").out;
  EXPECT_NE(info.find("every 3. frame, the last 30 % of the path"), std::string::npos) << info;
  // A scene of a version without the rule is read as one that has not used it.
  std::string scene = simuli::read_file(folder_ / "end.scene" / "scene.json");
  const std::string line = "\"held_out_last\": 0.3,";
  ASSERT_NE(scene.find(line), std::string::npos) << scene;
  simuli::write_file_atomically(folder_ / "end.scene" / "scene.json",
                                scene.erase(scene.find(line), line.size()));
  EXPECT_EQ(nlohmann::json::parse(run("eval end.scene s.log --json").out).at("images"), 2);
  expect_failure(
      "train s.log -o x.scene --held-out-last 1", kUsage, "held_out_last: found 1, allowed 0 to 0.9");
}

TEST_F(HeldOutCli, TheMiddleOfThePathIsHeldOutAndToldApart) {
  const std::string rule = "--held-out 5 --held-out-middle 0.3 --iterations 1 --set init.voxel_m=0.3";
  ASSERT_EQ(run("train s.log -o middle.scene " + rule).exit_code, 0);
  const Outcome text = run("eval middle.scene s.log");
  EXPECT_NE(text.out.find("between training frames                1 + 1"), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("in the middle of the path              2 + 2"), std::string::npos) << text.out;
  const nlohmann::json both = nlohmann::json::parse(run("eval middle.scene s.log --json").out);
  EXPECT_EQ(both.at("held_out_middle"), 0.3);
  EXPECT_EQ(both.at("middle").at("images"), 2);
  EXPECT_TRUE(both.at("beyond").is_null());
  const auto middle = nlohmann::json::parse(run("eval middle.scene s.log --held-out-middle 0.3 --json").out);
  EXPECT_EQ(middle.at("psnr_db"), both.at("middle").at("psnr_db"));
  EXPECT_EQ(middle.at("distance_median_m"), both.at("middle").at("distance_median_m"));
  const std::string info = run("info middle.scene").out;
  EXPECT_NE(info.find("every 5. frame, the middle 30 % of the path"), std::string::npos) << info;
  expect_failure(
      "train s.log -o x.scene --held-out-middle 1", kUsage, "held_out_middle: found 1, allowed 0 to 0.9");
}

TEST_F(HeldOutCli, EverySensorIsHeldOutAlikeAndOneWhole) {
  ASSERT_EQ(run("synth street -o rig.log --length 12 --frames 6 --cameras 2 --lidars 1 --image-width 48 "
                "--image-height 27 --lidar-columns 60")
                .exit_code,
            0);
  const std::string few = " --iterations 1 --set init.voxel_m=0.3";
  // Two cameras and every 2nd frame: counted over both together one would be held out whole.
  const Outcome trained = run("train rig.log -o rig.scene --held-out 2" + few);
  ASSERT_EQ(trained.exit_code, 0) << trained.err;
  EXPECT_NE(trained.err.find("front 3 (3 held out), left 3 (3 held out), top 3 (3 held out)"),
            std::string::npos)
      << trained.err;
  const auto all = nlohmann::json::parse(run("eval rig.scene rig.log --json").out);
  EXPECT_EQ(all.at("by_sensor").at("front").at("images"), 3);
  EXPECT_EQ(all.at("by_sensor").at("left").at("images"), 3);
  EXPECT_EQ(all.at("by_sensor").at("top").at("sweeps"), 3);
  // A scene that does not say how it counted is of a version that counted all pictures together.
  std::string scene = simuli::read_file(folder_ / "rig.scene" / "scene.json");
  const std::string line = "\"held_out_by_sensor\": true,";
  ASSERT_NE(scene.find(line), std::string::npos) << scene;
  simuli::write_file_atomically(folder_ / "rig.scene" / "scene.json",
                                scene.erase(scene.find(line), line.size()));
  EXPECT_EQ(nlohmann::json::parse(run("eval rig.scene rig.log --json").out).at("by_picture").size(), 6);

  const Outcome front = run("train rig.log -o front.scene --held-out 3 --held-out-sensor left" + few);
  ASSERT_EQ(front.exit_code, 0) << front.err;
  EXPECT_NE(front.err.find("front 4 (2 held out), left none (6 held out)"), std::string::npos) << front.err;
  EXPECT_EQ(front.err.find("warning: no frame"), std::string::npos) << front.err;  // it was asked for
  const auto held = nlohmann::json::parse(run("eval front.scene rig.log --json").out);
  EXPECT_EQ(held.at("sensor").at("images"), 6);
  EXPECT_EQ(held.at("between").at("images"), 2);
  const auto left =
      nlohmann::json::parse(run("eval front.scene rig.log --held-out-sensor left --support --json").out);
  EXPECT_EQ(left.at("support").at("without_tint"), nlohmann::json::array({"left"}));
  EXPECT_TRUE(
      nlohmann::json::parse(run("eval front.scene rig.log --held-out-sensor top --support --json").out)
          .at("support")
          .at("without_tint")
          .empty());
  EXPECT_EQ(left.at("images"), 6);
  EXPECT_EQ(left.at("sweeps"), 0);
  EXPECT_EQ(left.at("psnr_db"), held.at("sensor").at("psnr_db"));
  EXPECT_NE(run("info front.scene").out.find("left none (6 held out)"), std::string::npos);

  ASSERT_EQ(run("train rig.log -o named.scene --held-out 3 --sensors front --sensors top" + few).exit_code,
            0);
  EXPECT_EQ(nlohmann::json::parse(run("info named.scene --json").out).at("training").at("held_out_sensors"),
            nlohmann::json::array({"left"}));
  expect_failure(
      "train rig.log -o x.scene --held-out-sensor rear", kUsage, "found rear, allowed front, left, top");
  expect_failure("train rig.log -o x.scene --sensors rear", kUsage, "--sensors: found rear, allowed front");
}

}  // namespace

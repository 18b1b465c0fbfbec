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

}  // namespace

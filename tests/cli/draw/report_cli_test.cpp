// simuli eval: its report, and its numbers frame by frame.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <string>

#include "io/base/file.hpp"
#include "tests/cli/cli_fixture.hpp"

namespace {

using namespace simuli::test;

class ReportCli : public Cli {};

TEST_F(ReportCli, ShowsWhatIsRecordedAndWhatIsNot) {
  make_street();
  const Outcome train =
      run("train s.log -o s.scene --held-out 2 --iterations 1 --set init.voxel_m=0.3 render.alpha_cut=0.005");
  ASSERT_EQ(train.exit_code, 0) << train.err;
  const Outcome eval =
      run("eval s.scene s.log --json --report r.html --duplicate car:other --move other:4,0,0");
  ASSERT_EQ(eval.exit_code, 0) << eval.err;
  const std::string html = simuli::read_file(folder_ / "r.html");
  for (const char* part : {"Compared with the log",
                           "Frame by frame",
                           "By range",
                           "Pictures: held-out frames",
                           "Sweeps: held-out frames",
                           "Points to turn",
                           "Another LiDAR",
                           "Cameras beyond the recording",
                           "Settings",
                           "Time on the device"}) {
    EXPECT_NE(html.find(std::string("\">") + part), std::string::npos) << part;
  }
  const auto shows = [&](const char* text) { return html.find(text) != std::string::npos; };
  EXPECT_TRUE(shows("<td>--duplicate car:other --move other:4,0,0</td>"));
  EXPECT_TRUE(shows("the rig 2 m to the left of where it drove"));
  EXPECT_TRUE(shows(": depth, "));
  EXPECT_TRUE(shows("that no recorded camera faced"));
  EXPECT_TRUE(shows("(--remove ")) << "an actor gone";
  EXPECT_TRUE(shows("data-name=\"recorded\""));
  EXPECT_TRUE(shows("data-name=\"rendered\""));
  EXPECT_TRUE(shows("data-name=\"ouster_os1_128@1024x10\""));
  EXPECT_TRUE(shows("<td>render.alpha_cut</td><td>0.005</td>"));
  EXPECT_FALSE(shows("http"));
  EXPECT_LT(html.size(), 2'000'000U);

  const nlohmann::json numbers = nlohmann::json::parse(eval.out);
  ASSERT_EQ(numbers.at("by_picture").size(), 3U);
  ASSERT_EQ(numbers.at("by_sweep").size(), 3U);
  double psnr_db = 0.0, raydrop = 0.0;
  for (const auto& picture : numbers.at("by_picture")) {
    EXPECT_EQ(picture.at("sensor"), "front");
    psnr_db += picture.at("psnr_db").get<double>() / 3.0;
  }
  for (const auto& sweep : numbers.at("by_sweep")) {
    EXPECT_EQ(sweep.at("sensor"), "top");
    raydrop += sweep.at("raydrop_accuracy").get<double>() / 3.0;
  }
  EXPECT_NEAR(psnr_db, numbers.at("psnr_db").get<double>(), 1e-9);
  EXPECT_NEAR(raydrop, numbers.at("raydrop_accuracy").get<double>(), 1e-9);
  EXPECT_EQ(numbers.at("by_picture").at(1).at("index"), 3);
}

}  // namespace

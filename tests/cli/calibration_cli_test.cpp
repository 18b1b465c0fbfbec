// simuli align and simuli fit.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/cli/cli_fixture.hpp"

namespace {

using namespace simuli::test;

TEST_F(Cli, AlignFindsThePathOfALog) {
  ASSERT_EQ(run("synth street -o street.log --frames 4 --image-width 32 --image-height 18 --no-moving-car")
                .exit_code,
            0);
  const Outcome outcome = run("align street.log -o aligned.log --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto report = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(report["path"]["sweeps"], 4);
  EXPECT_NEAR(report["path"]["length_m"].get<double>(), 3.2, 0.05);
  EXPECT_EQ(report["path"]["spin"]["direction"], "clockwise");
  EXPECT_LT(report["path"]["point_to_plane"]["refined"]["median_m"].get<double>(), 0.02);
  EXPECT_EQ(run("info aligned.log").exit_code, 0);
  EXPECT_TRUE(fs::exists(folder_ / "aligned.log" / "sweeps"));
  const Outcome text = run("align street.log");
  ASSERT_EQ(text.exit_code, 0) << text.err;
  EXPECT_NE(text.out.find("spin: clockwise"), std::string::npos) << text.out;
  expect_failure("align street.log -o aligned.log", kInput, "aligned.log");
  expect_failure("align street.log --camera rear --keep-path", kInput, "rear");
  expect_failure("align street.log --keep-path", kUsage, "--camera");
  expect_failure("align street.log --camera front --apply-cameras", kUsage, "--output");
  expect_failure("align nowhere.log", kInput, "nowhere.log");
}

TEST_F(Cli, AlignEndsWithItsCodeWhereACameraIsRefused) {
  // Pictures of 32 x 18 px have too few edges.
  ASSERT_EQ(run("synth street -o street.log --frames 4 --image-width 32 --image-height 18").exit_code, 0);
  for (const std::string options : {"", "-o out.log", "-o out.log --apply-cameras"}) {
    const Outcome outcome = run("align street.log --keep-path --camera front --json " + options);
    EXPECT_EQ(outcome.exit_code, 6) << options;
    EXPECT_NE(outcome.err.find("mounting of camera front: "), std::string::npos) << outcome.err;
    const auto report = nlohmann::json::parse(outcome.out);  // what is known is told all the same
    EXPECT_EQ(report["cameras"][0]["determined"], false);
    EXPECT_FALSE(report.contains("log"));
    EXPECT_FALSE(fs::exists(folder_ / "out.log")) << options;
  }
}

TEST_F(Cli, FitLensSaysWhatIsLeft) {
  const Outcome outcome = run("fit lens tum_vi_cam0 --model ftheta_angle_to_radius -o lens.json --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto report = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(report["camera"]["model"], "ftheta_angle_to_radius");
  EXPECT_LT(report["rms_px"].get<double>(), 0.1);
  const Outcome read = run("info lens.json --json");
  EXPECT_EQ(nlohmann::json::parse(read.out), report["camera"]) << read.err;
  EXPECT_EQ(run("fit lens lens.json --model opencv_fisheye").exit_code, 0);
  expect_failure("fit lens tum_vi_cam0 --model ftheta", kUsage, "opencv_fisheye");
  expect_failure("fit lens tum_vi_cam0 --model equirectangular", kUsage, "no parameter to fit");
  expect_failure("fit lens no_such_camera --model pinhole", kUsage, "no_such_camera");
  expect_failure("fit", kUsage, "found no command, allowed ");
}

TEST_F(Cli, FitBeamsRefusesWhatIsNoSweep) {
  expect_failure("fit beams nowhere", kInput, "nowhere");
  fs::create_directory(folder_ / "empty");
  expect_failure("fit beams empty", kInput, "found none");
  std::ofstream(folder_ / "empty" / "a.bin") << "not 16 bytes";
  expect_failure("fit beams empty", kInput, "multiple of 16");
}

}  // namespace

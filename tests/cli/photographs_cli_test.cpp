// Scenes without a LiDAR, and programs that simuli starts.
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/cli/cli_fixture.hpp"

namespace {

using namespace simuli::test;

/// Programs that start simuli may hand on an ignored SIGCHLD, with which the system keeps no exit code of a child.
TEST_F(Cli, ExitCodesOfProgramsAreReadWhereSigchldIsIgnored) {
  make_street_scene();
  const auto run_ignoring = [&](const std::string& arguments) {
    return run_line(fmt::format(
        "PATH=\"$PWD:$PATH\" bash -c 'trap \"\" CHLD; exec \"$@\"' bash '{}' {}", program_, arguments));
  };
  const auto write_program = [&](const char* name, const char* text) {
    std::ofstream(folder_ / name) << "#!/bin/sh\n" << text;
    fs::permissions(folder_ / name, fs::perms::owner_all);
  };
  write_program("ffmpeg", "for last; do :; done\ncat > \"$last\"\n");
  const Outcome video = run_ignoring("render s.scene --sensor front --times 0:0.1:0.1 -o v.mp4");
  EXPECT_EQ(video.exit_code, 0) << video.err;
  EXPECT_TRUE(fs::exists(folder_ / "v.mp4"));

  write_program("copy_and_fail", "cd \"$1\"\nfor f in 0*[0-9].png; do cp $f \"$2/\"; done\nexit 5\n");
  const Outcome train = run_ignoring(
      "train s.log -o f.scene --iterations 8 --fixer copy_and_fail --set init.voxel_m=0.3 fixer.views=1");
  EXPECT_EQ(train.exit_code, kInput) << train.err;
  EXPECT_NE(train.err.find("found exit code 5"), std::string::npos) << train.err;
  EXPECT_FALSE(fs::exists(folder_ / "f.scene"));
}

/// Cameras alone: photographs of the street with the poses that its log tells.
TEST_F(Cli, PhotographsAreEnough) {
  ASSERT_EQ(run("synth street -o s.log --frames 10 --image-width 64 --image-height 36 --lidar-columns 90 "
                "--no-moving-car --speed 4")
                .exit_code,
            0);
  const nlohmann::json log = nlohmann::json::parse(std::ifstream(folder_ / "s.log" / "log.json"));
  const nlohmann::json& camera = log.at("cameras").at(0);
  nlohmann::json transforms = {
      {"w", 64}, {"h", 36}, {"fl_x", camera.at("fx_px")}, {"camera_model", "PINHOLE"}};
  const nlohmann::json& path = log.at("world_from_rig");
  for (const nlohmann::json& image : log.at("images")) {
    // The street's rig drives straight ahead: the nearest pose before will do, plus x.
    std::size_t k = 0;
    while (k + 1 < path.size() && path.at(k + 1).at("time_ns") <= image.at("time_start_ns")) ++k;
    const auto& p = path.at(k).at("position_m");
    transforms["frames"].push_back(
        {{"file_path", "s.log/" + image.at("file").get<std::string>()},
         {"transform_matrix", {{0, 0, -1, p.at(0)}, {-1, 0, 0, p.at(1)}, {0, 1, 0, p.at(2)}, {0, 0, 0, 1}}}});
  }
  transforms["frames"][0]["mask_path"] = "masks/0.png";
  for (int i = 0; i < 2; ++i) transforms["frames"][i]["depth_file_path"] = "depth.png";
  std::ofstream(folder_ / "transforms.json") << transforms.dump();
  const Outcome import = run("import nerfstudio transforms.json -o p.log --metres-per-unit 1");
  ASSERT_EQ(import.exit_code, 0) << import.err;
  EXPECT_NE(import.err.find("10 photographs (0 listed but missing)"), std::string::npos) << import.err;
  for (const char* note : {"1 masks of single photographs are left out", "2 depth pictures are left out"})
    EXPECT_NE(import.err.find(note), std::string::npos) << import.err;
  const Outcome train = run("train p.log -o p.scene --iterations 5 --json");
  ASSERT_EQ(train.exit_code, 0) << train.err;
  EXPECT_EQ(nlohmann::json::parse(train.out).at("lidar_particles"), 0);
  EXPECT_GT(nlohmann::json::parse(train.out).at("camera_particles"), 100);
  const Outcome eval = run("eval p.scene p.log --json");
  ASSERT_EQ(eval.exit_code, 0) << eval.err;
  EXPECT_GT(nlohmann::json::parse(eval.out).at("psnr_db"), 12.0);
  EXPECT_TRUE(nlohmann::json::parse(eval.out).at("distance_median_m").is_null());
  EXPECT_EQ(run("render p.scene --sensor camera_0 --trajectory p.log --frames 0:1 -o p").exit_code, 0);
  expect_failure("render p.scene --sensor velodyne_vlp16 -o x", kInput, "lidars: found none");
  // Another vehicle's camera in the first one's place.
  const Outcome other = run("render p.scene --sensor tum_vi_cam0 --scale 0.1 --times 1:1:1 -o fisheye");
  EXPECT_EQ(other.exit_code, 0) << other.err;
  EXPECT_TRUE(fs::exists(folder_ / "fisheye" / "tum_vi_cam0_000000.png"));
  expect_failure("render p.scene --sensor tum_vi_cam9 -o x", kUsage, "tum_vi_cam0");
}

}  // namespace

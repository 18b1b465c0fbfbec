// Commands that need no device.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <regex>

#include "tests/cli/cli_fixture.hpp"
#include "tests/io/ascii_ply.hpp"

namespace {

using namespace simuli::test;

TEST_F(Cli, UsageErrorsAreOneLineAndExitWith2) {
  expect_failure("", kUsage, "found no command, allowed actors, ");
  expect_failure("fly", kUsage, "fly");
  expect_failure("info", kUsage, "TARGET");
  expect_failure("info generic64 --no-such-option", kUsage, "--no-such-option");
  expect_failure("synth street", kUsage, "--output");
  expect_failure("synth street -o x.log --frames many", kUsage, "--frames");
  expect_failure("info generic64 row", kUsage, "generic64 is a sensor");
  expect_failure("render s.scene --sensor front -o x.mp4 --fps 1e300", kUsage, "--fps");
  expect_failure("render s.scene -o x --fps 25", kUsage, "--fps: found with \"x\", allowed with a video");
  expect_failure("render s.scene -o x.mp4 --start-ns 5",
                 kUsage,
                 "--start-ns: found with \"x.mp4\", allowed with an .mcap");
  expect_failure(
      "render s.scene -o x.mp4 --cloud-frame world", kUsage, "--cloud-frame: found with \"x.mp4\"");
  expect_failure("synth street -o x.log --frames 0", kUsage, "--frames: found 0, allowed 1 to 10000");
  expect_failure("render s.scene --sensor front -o x --speed nan", kUsage, "--speed");
  expect_failure("demo -o d --iterations=-1", kUsage, "iterations");  // before the street is made
}

TEST_F(Cli, QualitiesAreNamed) {
  expect_failure(
      "--quality best info generic64", kUsage, "found best, allowed draft, balanced, exact, reference");
  for (const char* name : {"draft", "balanced", "exact", "reference"}) {
    EXPECT_EQ(run(std::string("--quality ") + name + " info generic64").exit_code, 0);
  }
}

/// Whatever else the command line lacks.
TEST_F(Cli, SetHelpListsKeysWithDefaultsRangesAndMeanings) {
  const auto line_of = [](const std::string& help, const std::string& key) {
    const std::size_t at = help.find("  " + key + '=');
    return at == std::string::npos ? "" : help.substr(at, help.find('\n', at) - at);
  };
  const Outcome train = run("train --set help");
  EXPECT_EQ(train.exit_code, 0);
  EXPECT_EQ(train.err, "");
  EXPECT_EQ(line_of(train.out, "loss.ssim"), "  loss.ssim=0.4  (0 or more)") << train.out;
  EXPECT_NE(train.out.find("\nStart\n  init.voxel_m=0.1  (0.001 to 50)\n      Side of"), std::string::npos);
  EXPECT_EQ(line_of(train.out, "render.extent").find("  render.extent=exact  ("), 0U);
  const Outcome draft = run("eval --set help --quality draft");
  EXPECT_EQ(line_of(draft.out, "render.shutter_iterations"),
            "  render.shutter_iterations=1  (0 to 64 (whole))");
  EXPECT_EQ(line_of(draft.out, "render.sh_storage").find("  render.sh_storage=half  ("), 0U);
  EXPECT_EQ(line_of(draft.out, "init.voxel_m"), "");
  const Outcome render = run("--json render --set help");
  const auto rows = nlohmann::json::parse(render.out);
  EXPECT_EQ(rows.at(0).at("key"), "render.precision");
  EXPECT_EQ(rows.at(0).at("default"), "float");
}

TEST_F(Cli, HelpAndVersionGoToStdout) {
  const Outcome help = run("--help");
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_NE(help.out.find("--quality"), std::string::npos);
  EXPECT_EQ(help.err, "");
  EXPECT_EQ(run("synth street --help").exit_code, 0);
  // "simuli 0.1.0", with the commit behind it where that is known; the build, and the device that commands
  // take.
  const std::string version = run("--version").out;
  const std::regex lines(
      "simuli [0-9.]+( \\([0-9a-f]{12,}(-dirty)?\\))?\nbuild: .+, .+ [0-9.]+, .+\ndevice: (.+) / .+, driver "
      ".+\n");
  std::smatch found;
  ASSERT_TRUE(std::regex_match(version, found, lines)) << version;
  EXPECT_NE(run("devices").out.find(found[3].str()), std::string::npos) << version;
  const Outcome without = run("--version >first.txt; SIMULI_DEVICE=none '" + program_ + "' --version");
  EXPECT_EQ(without.exit_code, 0);
  EXPECT_NE(without.out.find("\ndevice: none ("), std::string::npos) << without.out;
}

#ifdef SIMULI_TEST_PICTURES
TEST_F(Cli, WithoutItsPictureLibraryOnlyWhatNeedsItEnds) {
  std::ofstream(folder_ / SIMULI_TEST_PICTURES) << "no library";
  ::setenv("LD_LIBRARY_PATH", folder_.c_str(), 1);
  expect_failure("synth street -o s.log --frames 1", 70, SIMULI_TEST_PICTURES ": found ");
  EXPECT_EQ(run("--version").exit_code, 0);
  EXPECT_EQ(run("info generic64").exit_code, 0);
  ::unsetenv("LD_LIBRARY_PATH");
  EXPECT_FALSE(fs::exists(folder_ / "s.log"));
}
#endif

TEST_F(Cli, InputErrorsNameWhatWasFoundAndExitWith3) {
  expect_failure("info nowhere.log", kInput, "nowhere.log: folder: found nothing of that name");
  expect_failure("info .", kInput, "neither log.json nor scene.json");
  fs::create_directory(folder_ / "broken.log");
  std::ofstream(folder_ / "broken.log" / "log.json") << "{\"name\": ";
  expect_failure("info broken.log", kInput, "log.json");
  for (const char* part : {"", " --frames 10:29", " --first 10"})
    expect_failure(fmt::format("import kitti nowhere -o x.log{}", part), kInput, "nowhere");
  for (const char* frames : {"3", "3:", "a:9", "1:2:3", "-1:2"}) {
    expect_failure(fmt::format("import kitti nowhere -o x.log --frames={}", frames),
                   kUsage,
                   fmt::format("--frames: found \"{}\", allowed a:b", frames));
  }
  expect_failure("import kitti360 nowhere -o x.log --frames 1:2 --last 2", kUsage, "--frames");
  expect_failure("import pandaset nowhere -o x.log", kInput, "camera: folders: found none");
  EXPECT_FALSE(fs::exists(folder_ / "x.log"));
}

TEST_F(Cli, AFolderThatMayNotBeEnteredIsToldSo) {
  fs::create_directory(folder_ / "locked.log");
  fs::permissions(folder_ / "locked.log", fs::perms::none);
  const bool is_root = ::geteuid() == 0;  // who may enter any
  if (is_root) fs::permissions(folder_, fs::perms::others_exec, fs::perm_options::add);
  const Outcome outcome = run_line(fmt::format(
      "{} '{}' info locked.log", is_root ? "setpriv --reuid=65534 --clear-groups" : "env", program_));
  EXPECT_EQ(outcome.exit_code, kInput);
  EXPECT_EQ(outcome.err,
            "simuli: locked.log: folder: found Permission denied, allowed a folder with search permission\n");
}

TEST_F(Cli, WhatCannotBeWrittenIsTold) {
  make_street();
  std::ofstream(folder_ / "file") << "no folder";
  expect_failure("train s.log -o x.scene --tensorboard file/events",
                 kInput,
                 "file/events: folder: found Not a directory, allowed one that can be made");
  // A limit on the size of files is as good as a full disk.
  const Outcome full =
      run_line(fmt::format("(ulimit -f 8; trap '' XFSZ; exec '{}' synth street -o x.log --frames 1 "
                           "--image-width 8 --image-height 8)",
                           program_));
  EXPECT_EQ(full.exit_code, kInput);
  EXPECT_NE(full.err.find("allowed a path with room for all of it (is the disk full?)\n"), std::string::npos)
      << full.err;
}

TEST_F(Cli, OutputThatCannotBeWrittenIsAnError) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "not run: writing to a full stdout, there is no /dev/full";
  for (const char* arguments : {"info generic64", "train --set help"}) {
    const int status =
        std::system(fmt::format("'{}' {} >/dev/full 2>/dev/null", SIMULI_PROGRAM, arguments).c_str());
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), kInput) << arguments;
  }
}

TEST_F(Cli, InfoOfABuiltInSensor) {
  const Outcome text = run("info generic64");
  EXPECT_EQ(text.exit_code, 0);
  EXPECT_NE(text.out.find("64 beams x 2650 columns"), std::string::npos) << text.out;
  const Outcome json = run("info generic64 --json --verbose");  // global options behind the command
  ASSERT_EQ(json.exit_code, 0);
  const nlohmann::json sensor = nlohmann::json::parse(json.out);
  EXPECT_EQ(sensor.at("rows").size(), 64U);
  EXPECT_EQ(sensor.at("columns"), 2650);
  EXPECT_NE(json.err.find(" s\n"), std::string::npos) << json.err;
}

TEST_F(Cli, InfoOfASensorFileAndOfAMode) {
  const Outcome built_in = run("info hesai_xt32@20 --json");
  ASSERT_EQ(built_in.exit_code, 0) << built_in.err;
  std::ofstream(folder_ / "mine.json") << built_in.out;
  const Outcome file = run("info mine.json --json");
  ASSERT_EQ(file.exit_code, 0) << file.err;
  EXPECT_EQ(file.out, built_in.out);
  const Outcome text = run("info mine.json");
  for (const char* part :
       {"32 beams x 1000 columns", "20 revolutions per second", "beam firing times", "licence"}) {
    EXPECT_NE(text.out.find(part), std::string::npos) << part << " is missing in " << text.out;
  }
  expect_failure("info hesai_xt32@7", kUsage, "allowed 2000x10");
  expect_failure("info hesai_x32", kInput, "like hesai_xt32");
  std::ofstream(folder_ / "wrong.json") << "{\"kind\": \"lidar\", \"colour\": 1}";
  expect_failure("info wrong.json", kInput, "wrong.json: ");
  EXPECT_NE(run("info sensors").out.find("velodyne_vlp16"), std::string::npos);
}

TEST_F(Cli, InfoOfACameraFile) {
  const Outcome built_in = run("info tum_vi_cam0 --json");
  ASSERT_EQ(built_in.exit_code, 0) << built_in.err;
  std::ofstream(folder_ / "mine.json") << built_in.out;
  const Outcome file = run("info mine.json --json");
  ASSERT_EQ(file.exit_code, 0) << file.err;
  EXPECT_EQ(file.out, built_in.out);
  const Outcome text = run("info mine.json");
  EXPECT_EQ(text.out, run("info tum_vi_cam0").out);
  for (const char* part : {"opencv_fisheye", "max_angle_rad", "pixels without a ray", "source"}) {
    EXPECT_NE(text.out.find(part), std::string::npos) << part << " is missing in " << text.out;
  }
  std::ofstream(folder_ / "wrong.json") << "{\"kind\": \"camera\", \"name\": \"a\", \"width_px\": 0}";
  expect_failure("info wrong.json", kInput, "wrong.json: width_px: found 0");
}

TEST_F(Cli, SynthesisedLogCanBeLookedAt) {
  const Outcome synth =
      run("synth street -o small.log --frames 2 --image-width 32 --image-height 18 --lidar-columns 36");
  ASSERT_EQ(synth.exit_code, 0) << synth.err;
  EXPECT_EQ(synth.err.find('\r'), std::string::npos);  // no bar where no terminal is
  const Outcome info = run("--json info small.log");
  ASSERT_EQ(info.exit_code, 0) << info.err;
  const nlohmann::json log = nlohmann::json::parse(info.out);
  EXPECT_EQ(log.at("kind"), "log");
  EXPECT_EQ(log.at("images"), 2);
  EXPECT_EQ(log.at("sweeps"), 2);
  ASSERT_EQ(log.at("actors").size(), 1U);
  EXPECT_EQ(log.at("actors").at(0).at("name"), "car");
  EXPECT_NE(run("info small.log").out.find("\n  actor  car "), std::string::npos);
  ASSERT_FALSE(log.at("sensors").empty());
  for (const auto& sensor : log.at("sensors")) {
    const std::string name = sensor.at("name");
    const Outcome one = run("info small.log " + name + " --json");
    ASSERT_EQ(one.exit_code, 0) << one.err;
    EXPECT_EQ(nlohmann::json::parse(one.out), sensor);
  }
  // Two sweeps show nothing that moves: labels are kept where that is asked for.
  for (const bool keeps : {false, true}) {
    const std::string name = keeps ? "kept.log" : "bare.log";
    const Outcome actors = run("--json actors small.log -o " + name + (keeps ? " --keep-labels" : ""));
    ASSERT_EQ(actors.exit_code, 0) << actors.err;
    EXPECT_EQ(nlohmann::json::parse(actors.out).contains("added"), keeps);
    const nlohmann::json written = nlohmann::json::parse(run("--json info " + name).out);
    EXPECT_EQ(written.at("actors").size(), keeps ? 1U : 0U);
  }
  expect_failure("info small.log rear", kInput, "sensor: found \"rear\"");
  expect_failure("synth street -o small.log", kInput, "small.log");  // never overwritten
}

/// Whole file, or its first `bytes`.
std::string head_of(const fs::path& file, std::size_t bytes = std::string::npos) {
  std::ifstream stream(file, std::ios::binary);
  std::string content{std::istreambuf_iterator<char>(stream), {}};
  return content.substr(0, bytes);
}
void put(const fs::path& file, const std::string& content) {
  std::ofstream(file, std::ios::binary) << content;
}
std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t place = text.find(from);
  EXPECT_NE(place, std::string::npos) << from;
  return place == std::string::npos ? text : text.replace(place, from.size(), to);
}

TEST_F(Cli, DamagedLogsAreOneLineAndLeaveNothing) {
  ASSERT_EQ(
      run("synth street -o a.log --frames 2 --image-width 32 --image-height 18 --lidar-columns 36").exit_code,
      0);
  const fs::path json = folder_ / "a.log" / "log.json";
  const std::string whole = head_of(json);
  put(json, replaced(whole, "\"width_px\"", "\"width_cm\""));
  expect_failure("train a.log -o s.scene", kInput, "width_px: found no such key; the keys are");
  put(json, replaced(whole, "\"name\"", "\"colour\": 1, \"name\""));
  expect_failure("info a.log", kInput, "colour");
  put(json, whole);

  fs::path picture;
  for (const auto& entry : fs::directory_iterator(folder_ / "a.log" / "images")) picture = entry.path();
  const std::string pixels = head_of(picture);
  put(picture, pixels.substr(0, pixels.size() / 2));
  expect_failure(
      "train a.log -o s.scene --held-out 0 --iterations 2", kInput, "(truncated), allowed all of them");
  put(picture, pixels);
  for (const auto& entry : fs::directory_iterator(folder_ / "a.log" / "sweeps")) picture = entry.path();
  put(picture, head_of(picture, 500));
  expect_failure("train a.log -o s.scene --held-out 0 --iterations 2", kInput, picture.filename().string());
  for (const auto& entry : fs::directory_iterator(folder_)) {
    EXPECT_EQ(entry.path().filename().string().find("s.scene"), std::string::npos) << entry.path();
  }
}

/// A scene of one particle: what `simuli info` can read.
std::string one_particle_ply() { return ascii_ply("", "1 2 3 0 0 0 0 -2 -2 -2 1 0 0 0\n"); }

TEST_F(Cli, DamagedScenesAreOneLine) {
  fs::create_directory(folder_ / "a.scene");
  put(folder_ / "a.scene" / "camera.ply", one_particle_ply());
  put(folder_ / "a.scene" / "lidar.ply", one_particle_ply());
  put(folder_ / "a.scene" / "scene.json",
      R"({"format": "simuli scene", "version": 1, "name": "one", "origin_m": [0, 0, 0],
    "camera_set": {"gaussians": 1, "sh_degree": 0, "background": [0, 0, 0]},
    "lidar_set": {"gaussians": 1, "sh_degree": 0, "background": [0, -4, 4]}, "cameras": [], "lidars": []})");
  const Outcome good = run("info a.scene");
  ASSERT_EQ(good.exit_code, 0) << good.err;
  const fs::path ply = folder_ / "a.scene" / "camera.ply";
  put(ply, replaced(one_particle_ply(), "1 2 3", "1 nan 3"));
  expect_failure("info a.scene", kInput, "camera.ply: ");
  put(ply, replaced(one_particle_ply(), "vertex 1", "vertex 4000000000"));
  expect_failure("info a.scene", kInput, "found 4000000000 vertices");
}

}  // namespace

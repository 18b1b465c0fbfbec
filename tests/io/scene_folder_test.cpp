#include "io/scene/scene_folder.hpp"

#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <numbers>

#include "io/base/file.hpp"
#include "io/base/json_reader.hpp"
#include "io/splat/ply.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

using test::expect_input_error;
using test::Scratch;

SceneFile some_scene() {
  SceneFile file;
  Scene& scene = file.scene;
  scene.name = "street \"corner\"";
  scene.origin = {500123.456789012, -5400000.1, 0.1};
  scene.camera = GaussianSet(SetKind::kCamera, 2, 3);
  scene.lidar = GaussianSet(SetKind::kLidar, 0, 2);
  for (GaussianSet* set : {&scene.camera, &scene.lidar}) {
    for (Eigen::Index i = 0; i < set->params.size(); ++i)
      set->params.data()[i] = 0.3F + 0.01F * static_cast<float>(i);
  }
  scene.camera_filter_px2 = kSplatVariance_px2;  // readable by the first version
  scene.camera_background = {0.1F, 0.2F, 0.3F};
  scene.lidar_background = {0.0F, -3.7F, 4.5F};
  scene.ray_drop = {{"top", RayDrop::start()}, {"front", RayDrop::of_logits()}};
  LogCamera camera;
  camera.model = {"front", 64, 48, 50.5, 51.5, 32.25, 24.125, ShutterKind::kTopToBottom};
  camera.rig_from_camera.translation = {1.5, -0.1, 1.4};
  file.cameras.push_back(camera);
  Lidar lidar;
  lidar.name = "top";
  lidar.rows = {{0.1, 0.01, 0.02, -0.03, 1e-6}, {-0.2, 0.0, 0.0, 0.0, 0.0}};
  lidar.columns = 90;
  lidar.azimuth_span = 2.0 * std::numbers::pi;
  lidar.range_min = 0.5;
  lidar.range_max = 80.0;
  lidar.beam_divergence = 0.003;
  file.lidars.push_back({lidar, Pose{}});
  const Pose turned{Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ())), {1.0, 2.0, 3.0}};
  file.world_from_rig = Trajectory({{0.0, Pose{}}, {0.1, turned}});
  file.recorded_frames = {{"front", {{0.0, 0.033}, {0.1, 0.133}}}, {"top", {{0.05, 0.15}}}};
  return file;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

TEST(SceneFolder, OccludersComeBackWithWhatTheyHide) {
  const Scratch scratch;
  SceneFile written = some_scene();
  Actor car{"car", "car", {4.0, 2.0, 1.5}, {{0.0, Pose{}}, {1.0, Pose{}}}};
  written.scene.actors = {car};
  write_scene(scratch / "plain", written);
  EXPECT_NE(read_file(scratch / "plain" / "scene.json").find("\"version\": 1"), std::string::npos);
  written.scene.occluders = {car};
  written.scene.camera.actor = {0, 2, 3};
  write_scene(scratch / "scene", written);
  EXPECT_NE(read_file(scratch / "scene" / "scene.json").find("\"version\": 3"), std::string::npos);
  const Scene read = read_scene(scratch / "scene").scene;
  ASSERT_EQ(read.occluders.size(), 1U);
  EXPECT_EQ(read.occluders[0].name, "car");
  EXPECT_EQ(read.occluders[0].size_m, car.size_m);
  EXPECT_EQ(read.occluders[0].track.size(), 2U);
  EXPECT_EQ(read.camera.actor, (std::vector<std::uint32_t>{0, 2, 3}));
  written.scene.camera.actor = {0, 2, 4};
  expect_input_error([&] { write_scene(scratch / "wrong", written); }, {"vertex 2: actor", "4", "0 to 3"});
}

TEST(SceneFolder, SaysHowWideThePixelsWereThatItWasTrainedWith) {
  const Scratch scratch;
  SceneFile written = some_scene();
  write_scene(scratch / "wide", written);
  const std::string silent = read_file(scratch / "wide" / "scene.json");
  EXPECT_EQ(silent.find("camera_filter_px2"), std::string::npos);  // as written by older versions
  EXPECT_EQ(read_scene(scratch / "wide").scene.camera_filter_px2, 0.3);
  written.scene.camera_filter_px2 = kPixelVariance_px2;
  write_scene(scratch / "own", written);
  const std::string text = read_file(scratch / "own" / "scene.json");
  EXPECT_NE(text.find("\"version\": 6"), std::string::npos);
  EXPECT_EQ(read_scene(scratch / "own").scene.camera_filter_px2, kPixelVariance_px2);
  write_file_atomically(scratch / "own" / "scene.json",
                        replaced(text, "\"camera_filter_px2\": 0.0", "\"camera_filter_px2\": -0.0"));
  expect_input_error([&] { (void)read_scene(scratch / "own"); }, {"camera_filter_px2", "0 to 100"});
}

TEST(SceneFolder, VistasComeBackWithTheirPaths) {
  const Scratch scratch;
  SceneFile written = some_scene();
  written.scene.visibility_sets = {{{{1e6, 2.0 / 3.0, 3.0}, {1e6 + 5.0, 1.0, 3.0}}}, {{{4.0, 5.0, 6.0}}}};
  written.scene.camera.actor = {0, 1, 2};
  write_scene(scratch / "scene", written);
  const std::string text = read_file(scratch / "scene" / "scene.json");
  EXPECT_NE(text.find("\"version\": 4"), std::string::npos);
  const Scene read = read_scene(scratch / "scene").scene;
  ASSERT_EQ(read.visibility_sets.size(), 2U);
  EXPECT_EQ(read.visibility_sets[0].path_m, written.scene.visibility_sets[0].path_m);  // every digit
  EXPECT_EQ(read.visibility_sets[1].path_m, written.scene.visibility_sets[1].path_m);
  EXPECT_EQ(read.camera.actor, (std::vector<std::uint32_t>{0, 1, 2}));
  // Including disoccluded and inpainted particles of a visibility set.
  Actor car{"car", "car", {4.0, 2.0, 1.5}, {}};
  for (const double time_s : {0.0, 2.0}) car.track.push_back({time_s, {}});
  written.scene.visibility_sets[1].occluders = {car};
  written.scene.camera.actor = {0, 2, 4};
  write_scene(scratch / "hiding", written);
  EXPECT_NE(read_file(scratch / "hiding" / "scene.json").find("\"version\": 5"), std::string::npos);
  const Scene hiding = read_scene(scratch / "hiding").scene;
  EXPECT_TRUE(hiding.visibility_sets.at(0).occluders.empty());
  EXPECT_EQ(hiding.visibility_sets.at(1).occluders.at(0).track.size(), 2U);
  EXPECT_EQ(hiding.camera.actor, written.scene.camera.actor);
  const auto refused = [&](const std::string& path, const std::string& found) {
    Json root = Json::parse(text);
    root["vistas"][1]["path_m"] = Json::parse(path);
    std::ofstream(scratch / "scene" / "scene.json") << root;
    expect_input_error([&] { (void)read_scene(scratch / "scene"); }, {"vistas[1].path_m", found});
  };
  refused("[1, 2, 3, 4]", "4 numbers");
  refused("[]", "0 numbers");
  refused("[1, 2, \"x\"]", "an array of numbers");
  written.scene.camera.actor = {0, 1, 5};
  expect_input_error([&] { write_scene(scratch / "wrong", written); }, {"vertex 2: actor", "5", "0 to 4"});
}

TEST(SceneFolder, RoundTrip) {
  const Scratch scratch;
  const SceneFile written = some_scene();
  write_scene(scratch / "scene", written);
  const SceneFile read = read_scene(scratch / "scene");
  EXPECT_EQ(read.scene.name, written.scene.name);
  EXPECT_EQ(read.scene.origin, written.scene.origin);  // every digit of a double
  EXPECT_EQ(read.scene.camera_background, written.scene.camera_background);
  EXPECT_EQ(read.scene.lidar_background, written.scene.lidar_background);
  EXPECT_EQ(read.scene.ray_drop, written.scene.ray_drop);  // every digit
  EXPECT_EQ(read.scene.camera.sh_degree, 2);
  EXPECT_EQ(read.scene.camera.kind, SetKind::kCamera);
  EXPECT_EQ(read.scene.lidar.kind, SetKind::kLidar);
  EXPECT_EQ(read.scene.camera.params, written.scene.camera.params);
  EXPECT_EQ(read.scene.lidar.params, written.scene.lidar.params);
  ASSERT_EQ(read.cameras.size(), 1U);
  EXPECT_EQ(read.cameras[0].model.cy, 24.125);
  EXPECT_EQ(read.cameras[0].model.shutter, ShutterKind::kTopToBottom);
  EXPECT_EQ(read.cameras[0].rig_from_camera.translation, written.cameras[0].rig_from_camera.translation);
  ASSERT_EQ(read.lidars.size(), 1U);
  ASSERT_EQ(read.lidars[0].with_rows().rows.size(), 2U);
  EXPECT_EQ(read.lidars[0].with_rows().rows[0].horizontal_offset, -0.03);
  EXPECT_EQ(read.lidars[0].with_rows().beam_divergence, 0.003);
  ASSERT_EQ(read.world_from_rig.poses().size(), 2U);
  constexpr double kRounding = 1e-12;  // of a quaternion that is normalised again
  EXPECT_TRUE(
      read.world_from_rig.at(0.05).rotation.isApprox(written.world_from_rig.at(0.05).rotation, kRounding));
  EXPECT_TRUE(read.world_from_rig.at(0.05).translation.isApprox(written.world_from_rig.at(0.05).translation,
                                                                kRounding));
  ASSERT_EQ(read.recorded_frames.size(), 2U);
  ASSERT_EQ(read.recorded_frames.at("front").size(), 2U);
  EXPECT_EQ(read.recorded_frames.at("front").at(1).time_start_s, 0.1);
  EXPECT_NEAR(read.recorded_frames.at("front").at(1).time_end_s, 0.133, 1e-12);
  ASSERT_EQ(read.recorded_frames.at("top").size(), 1U);
  EXPECT_NEAR(read.recorded_frames.at("top").at(0).time_start_s, 0.05, 1e-12);
}

TEST(SceneFolder, SceneWithoutSensorsOrGaussiansIsAScene) {
  const Scratch scratch;
  write_scene(scratch / "scene", SceneFile{});
  const SceneFile read = read_scene(scratch / "scene");
  EXPECT_EQ(read.scene.camera.size(), 0);
  EXPECT_TRUE(read.world_from_rig.poses().empty());
}

TEST(SceneFolder, OverwritingReplacesEverything) {
  const Scratch scratch;
  write_scene(scratch / "scene", some_scene());
  SceneFile second = some_scene();
  second.scene.camera = GaussianSet(SetKind::kCamera, 0, 1);
  second.scene.camera.rotation()(0, 0) = 1.0F;
  write_scene(scratch / "scene", second);
  EXPECT_EQ(read_scene(scratch / "scene").scene.camera.size(), 1);
}

TEST(SceneFolder, BadSceneFilesAreRefused) {
  const Scratch scratch;
  write_scene(scratch / "scene", some_scene());
  const std::filesystem::path file = scratch / "scene/scene.json";
  const std::string good = read_file(file);
  const auto refused =
      [&](const std::string& from, const std::string& to, const std::vector<std::string>& words) {
        write_file_atomically(file, replaced(good, from, to));
        expect_input_error([&] { (void)read_scene(scratch / "scene"); }, words);
      };
  refused("\"name\"", "\"colour\": 1, \"name\"", {"scene.json", "colour"});
  refused("\"sh_degree\": 2", "\"sh_degree\": 2, \"degrees\": 2", {"camera_set", "degrees"});
  refused("\"origin_m\"", "\"origin_cm\"", {"origin"});
  refused("simuli scene", "other scene", {"format", "other scene"});
  refused("\"version\": 1", "\"version\": 7", {"version", "7", "1 to 6"});
  refused("\"gaussians\": 3", "\"gaussians\": 4", {"camera.ply", "3 Gaussians", "4"});
  refused("\"gaussians\": 3", "\"gaussians\": \"3\"", {"camera_set.gaussians"});
  refused("\"sh_degree\": 2", "\"sh_degree\": 1", {"camera.ply", "SH degree", "found 2"});
  refused("\"sh_degree\": 0", "\"sh_degree\": 4", {"lidar_set.sh_degree", "4"});
  refused("4.5", "4.5e300", {"lidar_set.background"});
  refused("\"sensor\": \"front\"", "\"sensor\": \"rear\"", {"recorded_frames[0].sensor", "rear"});
  refused("\"sensor\": \"front\"", "\"sensor\": \"top\"", {"recorded_frames[1].sensor", "twice"});
  refused("\"time_end_ns\": 133000000", "\"time_end_ns\": 99999999", {"frames[1].time_end_ns"});
  refused("\"frames\": [", "\"frames\": [], \"others\": [", {"recorded_frames[0].frames", "none"});
  refused("\"time_start_ns\": 0", "\"time_start_ns\": 20000000000", {"recorded_frames[0].frames[0]"});
  refused("{", "", {"scene.json"});
}

TEST(SceneFolder, HalfAFolderIsRefused) {
  const Scratch scratch;
  expect_input_error([&] { (void)read_scene(scratch / "none"); }, {"scene.json"});
  write_scene(scratch / "scene", some_scene());
  std::filesystem::remove(scratch / "scene/lidar.ply");
  expect_input_error([&] { (void)read_scene(scratch / "scene"); }, {"lidar.ply"});
  write_scene(scratch / "scene", some_scene());
  std::filesystem::remove(scratch / "scene/scene.json");
  expect_input_error([&] { (void)read_scene(scratch / "scene"); }, {"scene.json"});
  // The sets of the two files are not interchangeable.
  write_scene(scratch / "scene", some_scene());
  std::filesystem::copy_file(scratch / "scene/camera.ply",
                             scratch / "scene/lidar.ply",
                             std::filesystem::copy_options::overwrite_existing);
  expect_input_error([&] { (void)read_scene(scratch / "scene"); }, {"lidar.ply", "channels"});
}

TEST(SceneFolder, WhatCannotBeReadBackLeavesTheOldSceneAlone) {
  const Scratch scratch;
  write_scene(scratch / "scene", some_scene());
  const auto refused = [&](const SceneFile& bad, const std::vector<std::string>& words) {
    expect_input_error([&] { write_scene(scratch / "scene", bad); }, words);
    EXPECT_EQ(read_scene(scratch / "scene").scene.camera.size(), 3);
  };
  SceneFile bad = some_scene();
  bad.scene.origin.x() = std::nan("");
  refused(bad, {"origin_m"});
  bad.scene.origin.x() = -2e8;
  refused(bad, {"origin_m", "up to"});
  bad = some_scene();
  bad.scene.lidar.params(1, kMeanRow) = std::nanf("");
  refused(bad, {"lidar.ply", "vertex 1: x"});
  bad = some_scene();
  std::get<Lidar>(bad.lidars[0].model).name = "front";
  refused(bad, {"front"});
  bad = some_scene();
  bad.cameras[0].model.fx = -1.0;
  refused(bad, {"fx_px"});
  bad = some_scene();
  bad.scene.lidar.kind = SetKind::kCamera;
  refused(bad, {"lidar.ply", "kind"});
}

}  // namespace
}  // namespace simuli

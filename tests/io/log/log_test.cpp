#include "io/log/log.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <variant>

#include "io/base/file.hpp"
#include "tests/io/linear.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace log_test {

namespace fs = std::filesystem;
using test::expect_input_error;
using test::Scratch;

constexpr std::int64_t kStart_ns = 1317042651106324297;
constexpr double kTime_s = 1e-9;  // times are whole nanoseconds on disk
constexpr double kExact = 1e-15;  // a unit quaternion is normalised once more when read

/// Returns a log of two images and one sweep; the recorded files exist but are empty.
Log some_log(const Scratch& scratch) {
  Log log;
  log.folder = scratch.path();
  log.name = "drive \"7\"";
  log.start_ns = kStart_ns;
  LogCamera camera;
  camera.model = {"front", 64, 48, 50.5, 51.5, 32.25, 24.125, ShutterKind::kTopToBottom};
  camera.rig_from_camera = {Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), {1.5, -0.1, 1.4}};
  log.cameras.push_back(camera);
  Lidar lidar;
  lidar.name = "top";
  lidar.rows = {{0.1, 0.01, 0.02, -0.03, 1e-6}, {-0.2, 0.0, 0.0, 0.0, 0.0}};
  lidar.columns = 90;
  lidar.azimuth_first = 0.1;
  lidar.azimuth_span = 2.0 * std::numbers::pi;
  lidar.spin = SpinDirection::kClockwise;
  lidar.range_min = 0.5;
  lidar.range_max = 80.0;
  lidar.beam_divergence = 3e-3;
  lidar.divergence_variance = 0.72;
  log.lidars.push_back({lidar, Pose{}});
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()));
  log.world_from_rig = Trajectory(
      {{0.05, {turn, {500123.456789012, -5400000.1, 0.1}}}, {0.15, {turn, {500124.5, -5400000, 0}}}});
  log.images = {{"front", "images/0.png", 0.06, 0.08}, {"front", "images/1.png", 0.1, 0.1}};
  log.sweeps = {{"top", "sweeps/0.exr", 0.0, 0.103490641}};
  fs::create_directory(scratch / "images");
  fs::create_directory(scratch / "sweeps");
  for (const char* name : {"images/0.png", "images/1.png", "sweeps/0.exr"}) (void)scratch.file(name, "");
  return log;
}

TEST(Log, IsReadInProportionToItsPath) {
  const Scratch scratches[2];
  for (const int which : {0, 1}) {
    Log log = some_log(scratches[which]);
    std::vector<TimedPose> poses;
    const int count = 25'000 * (which + 1);
    for (int i = 0; i <= count; ++i) poses.push_back({0.05 + 0.1 * i / count, {}});
    log.world_from_rig = Trajectory(std::move(poses));
    write_log(log);
  }
  test::expect_linear([&](int which) { (void)read_log(scratches[which].path()); });
}

TEST(Log, ReadsWhatItWrote) {
  const Scratch scratch;
  const Log log = some_log(scratch);
  write_log(log);
  const Log read = read_log(scratch.path());
  EXPECT_EQ(read.folder, scratch.path());
  EXPECT_EQ(read.name, log.name);
  EXPECT_EQ(read.start_ns, kStart_ns);
  const Camera& camera = read.camera("front").model;
  EXPECT_EQ(camera.width, 64);
  EXPECT_EQ(camera.height, 48);
  EXPECT_EQ(camera.fx, 50.5);
  EXPECT_EQ(camera.fy, 51.5);
  EXPECT_EQ(camera.cx, 32.25);
  EXPECT_EQ(camera.cy, 24.125);
  EXPECT_EQ(camera.shutter, ShutterKind::kTopToBottom);
  EXPECT_EQ(read.camera("front").rig_from_camera.translation, log.cameras[0].rig_from_camera.translation);
  EXPECT_LT(
      read.camera("front").rig_from_camera.rotation.angularDistance(log.cameras[0].rig_from_camera.rotation),
      1e-7);
  const Lidar& lidar = read.lidar("top").with_rows();
  ASSERT_EQ(lidar.row_count(), 2);
  EXPECT_EQ(lidar.rows[0].elevation, 0.1);
  EXPECT_EQ(lidar.rows[0].azimuth_offset, 0.01);
  EXPECT_EQ(lidar.rows[0].vertical_offset, 0.02);
  EXPECT_EQ(lidar.rows[0].horizontal_offset, -0.03);
  EXPECT_EQ(lidar.rows[0].time_offset, 1e-6);
  EXPECT_EQ(lidar.columns, 90);
  EXPECT_EQ(lidar.azimuth_first, 0.1);
  EXPECT_EQ(lidar.azimuth_span, 2.0 * std::numbers::pi);
  EXPECT_EQ(lidar.spin, SpinDirection::kClockwise);
  EXPECT_EQ(lidar.range_min, 0.5);
  EXPECT_EQ(lidar.range_max, 80.0);
  EXPECT_EQ(lidar.beam_divergence, 3e-3);
  EXPECT_EQ(lidar.divergence_variance, 0.72);
  ASSERT_EQ(read.world_from_rig.poses().size(), 2U);
  const TimedPose& pose = read.world_from_rig.poses()[0];
  EXPECT_NEAR(pose.time_s, 0.05, kTime_s);
  EXPECT_EQ(pose.pose.translation, log.world_from_rig.poses()[0].pose.translation);
  EXPECT_NEAR(pose.pose.rotation.w(), std::cos(0.15), kExact);
  EXPECT_NEAR(pose.pose.rotation.z(), std::sin(0.15), kExact);
  ASSERT_EQ(read.images.size(), 2U);
  EXPECT_EQ(read.images[0].camera, "front");
  EXPECT_EQ(read.images[0].file, "images/0.png");
  EXPECT_NEAR(read.images[0].time_start_s, 0.06, kTime_s);
  EXPECT_NEAR(read.images[0].time_end_s, 0.08, kTime_s);
  ASSERT_EQ(read.sweeps.size(), 1U);
  EXPECT_EQ(read.sweeps[0].lidar, "top");
  EXPECT_EQ(read.sweeps[0].file, "sweeps/0.exr");
  EXPECT_NEAR(read.sweeps[0].time_end_s, 0.103490641, kTime_s);
  EXPECT_EQ(sweep_s(read.lidars[0].model), 0.103490641);
}

TEST(Log, LidarsTurnInTheTimeOfTheirSweeps) {
  const Scratch scratch;
  Log log = some_log(scratch);
  for (const double end_s : {0.02, 0.015}) {
    log.sweeps.push_back({"top", "sweeps/1.exr", 0.0, end_s});
  }
  log.sweeps.erase(log.sweeps.begin());
  log.sweeps.push_back({"top", "sweeps/1.exr", 0.01, 0.031});
  (void)scratch.file("sweeps/1.exr", "");
  write_log(log);
  EXPECT_EQ(sweep_s(read_log(scratch.path()).lidars[0].model), 0.02);  // the median
}

TEST(Log, HoldsRayLists) {
  const Scratch scratch;
  Log log = some_log(scratch);
  RayList list;
  list.name = "petals";
  list.azimuth = {0.1, -0.2, 3.0};
  list.elevation = {0.0, 0.05, -0.1};
  list.time_fraction = {0.0, 0.25, 0.5};
  list.origin = {{0.0, 0.01, 0.02}, {0.0, 0.0, 0.0}, {-0.1, 0.0, 0.0}};
  list.range_min = 0.5;
  list.range_max = 60.0;
  log.lidars.push_back({list, Pose{Eigen::Quaterniond::Identity(), {1.0, 2.0, 3.0}}});
  log.sweeps.push_back({"petals", "sweeps/1.exr", 0.06, 0.16});
  write_sweep(scratch / "sweeps/1.exr",
              {nominal_rays(log.lidars[1].model), {1.0F, 0.0F, 3.0F}, {0.5F, 0.0F, 0.25F}});
  write_log(log);

  const Log read = read_log(scratch.path());
  const auto& same = std::get<RayList>(read.lidar("petals").model);
  EXPECT_EQ(same.azimuth, list.azimuth);
  EXPECT_EQ(same.elevation, list.elevation);
  EXPECT_EQ(same.time_fraction, list.time_fraction);
  EXPECT_EQ(same.origin, list.origin);
  EXPECT_EQ(read.lidar("petals").rig_from_lidar.translation.y(), 2.0);
  const Sweep sweep = read_sweep(scratch / read.sweeps[1].file, read.lidar("petals").model);
  EXPECT_EQ(sweep.rays.rows, 1);
  EXPECT_EQ(sweep.rays.columns, 3);
  EXPECT_EQ(sweep.rays.azimuth[2], 3.0F);
  EXPECT_EQ(sweep.range[2], 3.0F);
  expect_input_error([&] { (void)read_sweep(scratch / read.sweeps[1].file, read.lidar("top").model); },
                     {"1.exr", "1 x 3", "2 x 90 of lidar top"});
  expect_input_error([&] { (void)read.lidar("petals").with_rows(); }, {"petals", "ray_list"});
}

TEST(Log, WritesTheSameBytesAgain) {
  const Scratch scratch;
  write_log(some_log(scratch));
  const std::string first = read_file(scratch / "log.json");
  write_log(read_log(scratch.path()));
  EXPECT_EQ(read_file(scratch / "log.json"), first);
  EXPECT_NE(first.find("1317042651156324297"), std::string::npos) << "int64 nanoseconds of the first pose";
}

/// Replaces the first `old_text` of a valid log.json and expects an error of the reader.
void refuse_edit(const std::string& old_text,
                 const std::string& new_text,
                 const std::vector<std::string>& words) {
  const Scratch scratch;
  write_log(some_log(scratch));
  std::string text = read_file(scratch / "log.json");
  const std::size_t at = text.find(old_text);
  ASSERT_NE(at, std::string::npos) << old_text;
  write_file_atomically(scratch / "log.json", text.replace(at, old_text.size(), new_text));
  std::vector<std::string> all{"log.json", "found", "allowed"};
  all.insert(all.end(), words.begin(), words.end());
  expect_input_error([&] { (void)read_log(scratch.path()); }, all);
}

TEST(Log, RefusesUnknownKeys) {
  refuse_edit("\"version\": 1,", "\"version\": 1, \"colour\": \"red\",", {"colour", "an unknown key"});
  refuse_edit("\"spin\":", "\"note\": 1, \"spin\":", {"lidars[0].note", "an unknown key"});
}

TEST(Log, RefusesWrongUnits) {
  refuse_edit("range_max_m", "range_max_cm", {"lidars[0].range_max_m", "range_max_cm"});
  refuse_edit("elevation_rad", "elevation_deg", {"lidars[0].rows[0].elevation_rad", "elevation_deg"});
  refuse_edit("time_start_ns", "time_start_s", {"images[0].time_start_ns", "time_start_s"});
}

TEST(Log, RefusesMissingKeysAndOtherTypes) {
  refuse_edit("\"width_px\": 64,", "", {"cameras[0].width_px", "no such key"});
  refuse_edit("\"width_px\": 64,", "\"width_px\": \"64\",", {"cameras[0].width_px", "\"64\""});
  refuse_edit("\"start_ns\": 1317042651106324297", "\"start_ns\": 1317042651.1", {"start_ns", "an integer"});
  refuse_edit("\"version\": 1", "\"version\": 2", {"version", "found 2"});
  refuse_edit("simuli log", "simuli scene", {"format", "simuli scene"});
}

TEST(Log, RefusesValuesThatNoSensorHas) {
  refuse_edit("\"fx_px\": 50.5", "\"fx_px\": -50.5", {"camera front", "fx_px", "-50.5"});
  refuse_edit("\"range_max_m\": 80.0", "\"range_max_m\": 0.1", {"lidar top", "range_max_m", "0.1"});
  refuse_edit("\"columns\": 90", "\"columns\": 0", {"lidars[0].columns", "found 0"});
  refuse_edit("\"kind\": \"lidar\"", "\"kind\": \"radar\"", {"lidars[0].kind", "radar", "ray_list"});
  refuse_edit("\"clockwise\"", "\"left\"", {"lidars[0].spin", "left", "counter_clockwise"});
  refuse_edit("top_to_bottom", "diagonal", {"cameras[0].shutter", "diagonal"});
  refuse_edit("-0.5,", "-0.9,", {"cameras[0].rig_from_camera.rotation_wxyz", "a unit quaternion"});
}

TEST(Log, RefusesFoldersForPictures) {
  const Scratch scratch;
  const Log log = some_log(scratch);
  write_log(log);
  fs::remove(scratch / log.images[0].file);
  fs::create_directory(scratch / log.images[0].file);
  expect_input_error([&] { (void)read_log(scratch.path()); }, {"images/0.png: file: found a folder"});
}

TEST(Log, RefusesDanglingNames) {
  refuse_edit("\"camera\": \"front\"", "\"camera\": \"rear\"", {"images[0].camera", "\"rear\"", "front"});
  refuse_edit("\"lidar\": \"top\"", "\"lidar\": \"roof\"", {"sweeps[0].lidar", "\"roof\"", "top"});
  refuse_edit("images/0.png", "images/7.png", {"images[0].file", "images/7.png", "not there"});
  refuse_edit("images/0.png", "../0.png", {"images[0].file", "../0.png", "a path inside the folder"});
  refuse_edit("images/0.png", "/dev/null", {"images[0].file", "/dev/null"});
  refuse_edit("\"name\": \"top\"", "\"name\": \"front\"", {"lidars", "\"front\" twice"});
}

TEST(Log, RefusesTimesOutOfOrder) {
  // 0.06 s and 0.08 s after the start: the first image; 0.05 s: the first pose.
  refuse_edit("1317042651166324297", "1317042651187324297", {"images[0].time_end_ns", "not before"});
  refuse_edit(
      "1317042651166324297", "1317042641166324297", {"images[0].time_start_ns", "span of world_from_rig"});
  refuse_edit("1317042651156324297", "1317042651956324297", {"world_from_rig", "strictly increasing"});
}

TEST(Log, RefusesToWriteWhatCannotBeRead) {
  const Scratch scratch;
  Log log = some_log(scratch);
  log.cameras[0].model.fx = std::nan("");
  expect_input_error([&] { write_log(log); }, {"camera front", "fx_px", "nan"});
  log.cameras[0].model.fx = 50.5;
  log.cameras[0].rig_from_camera.translation.x() = std::nan("");
  expect_input_error([&] { write_log(log); }, {"pose"});
  EXPECT_FALSE(fs::exists(scratch / "log.json"));
  expect_input_error([&] { (void)read_log(scratch.path()); }, {"log.json", "allowed a readable file"});
}

TEST(Log, NamesTheSensorsItKnows) {
  const Scratch scratch;
  const Log log = some_log(scratch);
  expect_input_error([&] { (void)log.camera("back"); }, {"log.json", "\"back\"", "allowed front"});
  expect_input_error([&] { (void)log.lidar("back"); }, {"log.json", "\"back\"", "allowed top"});
}

}  // namespace log_test
}  // namespace simuli

// Tests logs to NCore and back: equal bits with the keys of simuli, NCore's precision without them, and
// one-line errors for damaged or unsupported files.
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "io/base/file.hpp"
#include "io/base/json_reader.hpp"
#include "io/import/ncore/ncore_log.hpp"
#include "io/ncore/models.hpp"
#include "io/ncore/ncore_export.hpp"
#include "io/ncore/poses.hpp"
#include "io/synth/long_street.hpp"
#include "io/zarr/zarr_store.hpp"
#include "tests/host/windshields.hpp"
#include "tests/io/ncore/ncore_fixture.hpp"
#include "tests/io/survey.hpp"

namespace simuli::test {
namespace {

namespace fs = std::filesystem;

void expect_same_files(const Log& a, const Log& b) {
  std::vector<std::string> files{"log.json"};
  for (const ImageFrame& frame : a.images) files.push_back(frame.file);
  for (const SweepFrame& frame : a.sweeps) files.push_back(frame.file);
  for (const std::string& file : files)
    EXPECT_EQ(read_file(a.folder / file), read_file(b.folder / file)) << file;
  EXPECT_EQ(log_hash(a), log_hash(b));
}

/// Expects equal sweeps up to single precision and microseconds.
void expect_near_sweeps(const Log& a, const Log& b) {
  ASSERT_EQ(a.sweeps.size(), b.sweeps.size());
  for (const SweepFrame& frame : a.sweeps) {
    const LidarModel &model_x = a.lidar(frame.lidar).model, &model_y = b.lidar(frame.lidar).model;
    const Sweep x = read_sweep(a.folder / frame.file, model_x),
                y = read_sweep(b.folder / frame.file, model_y);
    for (std::size_t i = 0; i < x.range.size(); ++i) {
      SCOPED_TRACE(frame.file + " ray " + std::to_string(i));
      ASSERT_EQ(x.range[i] > 0.0F, y.range[i] > 0.0F);
      ASSERT_EQ(x.intensity[i], y.intensity[i]);
      ASSERT_NEAR(x.rays.time_fraction[i], y.rays.time_fraction[i], 1e-5);
      const Eigen::Vector3d dx = Lidar::direction(x.rays.azimuth[i], x.rays.elevation[i]),
                            dy = Lidar::direction(y.rays.azimuth[i], y.rays.elevation[i]);
      if (!(x.range[i] > 0.0F)) {
        ASSERT_NEAR((dx - dy).norm(), 0.0, 1e-6);
        continue;
      }
      const Eigen::Vector3d px = ray_origin(model_x, x.rays, i) + x.range[i] * dx,
                            py = ray_origin(model_y, y.rays, i) + y.range[i] * dy;
      ASSERT_NEAR((px - py).norm(), 0.0, 1e-6 * (10.0 + x.range[i]));
    }
  }
}

TEST_F(NcoreTest, ComesBackBitForBitFromEitherContainer) {
  const Log log = street();
  for (const char* name : {"a.zarr", "a.zarr.itar"}) expect_same_files(log, there_and_back(log, name));
  EXPECT_EQ(report_.unposed + report_.twice + report_.echoes, 0U);
  EXPECT_GT(report_.returned, 1000U);
}

TEST_F(NcoreTest, KeepsTimesThatAreNoMicrosecondsAndMeasuredRays) {
  Log log = street();
  std::mt19937 random(3);
  std::uniform_real_distribution<float> noise(-1e-4F, 1e-4F);
  const fs::path folder = scratch_ / "moved.log";
  fs::copy(log.folder, folder, fs::copy_options::recursive);
  log.folder = folder;
  log.start_ns = 1'700'000'000'123'456'789;
  for (SweepFrame& frame : log.sweeps) {
    const LidarModel& model = log.lidar(frame.lidar).model;
    Sweep sweep = read_sweep(folder / frame.file, model);
    for (float& azimuth : sweep.rays.azimuth) azimuth += noise(random);
    for (float& elevation : sweep.rays.elevation) elevation += noise(random);
    write_sweep(folder / frame.file, sweep);
    frame.time_start_s += 1.23e-7;
  }
  write_log(log);
  const Log moved = read_log(folder);
  expect_same_files(moved, there_and_back(moved));
}

TEST_F(NcoreTest, IsNearWithoutWhatIsOurs) {
  const Log log = street();
  (void)export_ncore(log, scratch_ / "a.zarr", {});
  strip();
  const Log plain = back("a.zarr");
  expect_near_sweeps(log, plain);
  ASSERT_EQ(plain.cameras.size(), log.cameras.size());
  for (const LogCamera& camera : log.cameras) {
    const LogCamera& other = plain.camera(camera.model.name);
    EXPECT_EQ(other.model, camera.model);  // stored in double precision
    EXPECT_TRUE(other.rig_from_camera.matrix().isApprox(camera.rig_from_camera.matrix(), 1e-12));
  }
  ASSERT_EQ(plain.world_from_rig.poses().size(), log.world_from_rig.poses().size());
  const double shift_s =
      static_cast<double>(plain.start_ns - log.start_ns) * 1e-9 - 1.0;  // none before 1970: 1 s later
  for (std::size_t i = 0; i < plain.world_from_rig.poses().size(); ++i) {
    const TimedPose &a = log.world_from_rig.poses()[i], &b = plain.world_from_rig.poses()[i];
    EXPECT_NEAR(b.time_s + shift_s, a.time_s, 1e-6);
    EXPECT_TRUE(a.pose.matrix().isApprox(b.pose.matrix(), 1e-12));
  }
  ASSERT_EQ(plain.actors.size(), log.actors.size());
  for (std::size_t i = 0; i < log.actors.size(); ++i) {
    EXPECT_EQ(plain.actors[i].name, log.actors[i].name);
    EXPECT_EQ(plain.actors[i].size_m, log.actors[i].size_m);
    ASSERT_EQ(plain.actors[i].track.size(), log.actors[i].track.size());
    for (std::size_t k = 0; k < log.actors[i].track.size(); ++k) {
      const Pose &a = log.actors[i].track[k].world_from_actor, &b = plain.actors[i].track[k].world_from_actor;
      EXPECT_TRUE(a.matrix().isApprox(b.matrix(), 1e-9)) << i << ' ' << k;
    }
  }
}

TEST_F(NcoreTest, BelievesTheFileWhereOursSaysOtherwise) {
  const Log log = street();
  (void)export_ncore(log, scratch_ / "a.zarr", {});
  edit("intrinsics/default/cameras/front/.zattrs", [](Json& json) {
    json["camera_model_parameters"]["focal_length"] = {41.0, 42.0};
  });
  edit("lidars/top/.zattrs", [](Json& json) { json["generic_meta_data"]["simuli"]["sensor"]["rows"] = 3; });
  const Log changed = back("a.zarr");
  EXPECT_EQ(changed.camera("front").model.fx, 41.0);
  EXPECT_EQ(changed.camera("front").model.fy, 42.0);
  EXPECT_EQ(changed.camera("left").model, log.camera("left").model);
  EXPECT_EQ(changed.lidar("top").with_rows().rows.size(), log.lidar("top").with_rows().rows.size());
}

TEST_F(NcoreTest, HasEveryLensWithACounterpart) {
  std::size_t known = 0;
  for (const std::string& name : builtin_camera_names()) {
    const Camera camera = builtin_camera(name);
    const Json json = ncore::intrinsics_of(camera);
    if (json.is_null()) continue;
    ++known;
    JsonObject object("file", "", json);
    const Camera again = ncore::camera_from_intrinsics(object, name);
    EXPECT_EQ(again.shutter, camera.shutter) << name;
    EXPECT_TRUE(ncore::is_same(ncore::intrinsics_of(again), json)) << name;
    for (const double x : {0.2, 0.5, 0.8}) {
      const Eigen::Vector2d pixel(x * camera.width, (1.0 - x) * camera.height);
      EXPECT_NEAR((again.unproject(pixel) - camera.unproject(pixel)).norm(), 0.0, 1e-9) << name;
    }
  }
  EXPECT_GE(known, 5U);
  Camera other = builtin_camera(builtin_camera_names().front());
  other.lens = Lens(LensKind::kEquirectangular, {});
  EXPECT_TRUE(ncore::intrinsics_of(other).is_null());
}

TEST_F(NcoreTest, KeepsWindshields) {
  Log log = street();
  const fs::path folder = scratch_ / "glass.log";
  fs::copy(log.folder, folder, fs::copy_options::recursive);
  log.folder = folder;
  for (const Windshield& glass : {test::glass_before_the_lens(), test::glass_by_its_way_back()}) {
    Camera& camera = log.cameras.front().model;
    camera.lens = camera.lens.behind(glass);
    write_log(log);
    const Log glazed = read_log(folder);
    EXPECT_EQ(glazed.cameras.front().model, camera);
    const std::string name = fmt::format("glass{}.zarr", static_cast<int>(glass.reference));
    expect_same_files(glazed, there_and_back(glazed, name));
    // Without the keys of simuli, and with only the kind beside the model, as in older files.
    Json json = ncore::intrinsics_of(camera);
    EXPECT_EQ(json["external_distortion_type"], "bivariate-windshield");
    Json& inside = json["camera_model_parameters"]["external_distortion_parameters"];
    EXPECT_EQ(inside["external_distortion_type"], "bivariate-windshield");
    inside.erase("external_distortion_type");
    JsonObject object("file", "", json);
    EXPECT_EQ(ncore::camera_from_intrinsics(object, camera.name).lens, camera.lens);
  }
}

TEST_F(NcoreTest, RefusesWhatItCannotRead) {
  const Log log = street();
  (void)export_ncore(log, scratch_ / "a.zarr", {});
  const std::string intrinsics = "intrinsics/default/cameras/front/.zattrs";
  const auto refused = [&](const std::string& key,
                           const std::function<void(Json&)>& change,
                           const std::vector<std::string>& words) {
    const std::string before = read_file(scratch_ / ("a.zarr/" + key));
    edit(key, change);
    expect_input_error([&] { (void)back("a.zarr"); }, words);
    std::ofstream(scratch_ / ("a.zarr/" + key)) << before;
  };
  const auto outside = [](Json parameters) {
    return [parameters](Json& json) {
      json["camera_model_parameters"]["external_distortion_parameters"] = parameters;
    };
  };
  refused(intrinsics,
          outside({{"external_distortion_type", "prism"}}),
          {"cameras/front", "external_distortion_type", "\"prism\"", "bivariate-windshield"});
  refused(intrinsics, outside({{"reference_poly", "SIDEWAYS"}}), {"reference_poly", "FORWARD or BACKWARD"});
  refused(intrinsics,
          outside({{"reference_poly", "FORWARD"},
                   {"horizontal_poly", {0, 1}},
                   {"vertical_poly", {0, 0, 1}},
                   {"horizontal_poly_inverse", {0, 1, 0}},
                   {"vertical_poly_inverse", {0, 0, 1}}}),
          {"windshield.horizontal", "2 coefficients"});
  refused(intrinsics,
          [](Json& json) { json["camera_model_type"] = "mei"; },
          {"camera_model_type", "\"mei\"", "ftheta"});
  refused(".zattrs", [](Json& json) { json["version"] = "v5"; }, {"version", "\"v5\"", "\"v4\""});
  refused(
      "cameras/front/.zattrs", [](Json& json) { json["component_version"] = "v2"; }, {"component_version"});
  const auto renamed = [](Json& json) { json = {{"('rig', 'map')", json.begin().value()}}; };
  refused("poses/default/dynamic_poses/.zattrs", renamed, {"rig to map", "rig in world", "--world-frame"});
  refused("poses/default/dynamic_poses/.zattrs",
          [](Json& json) { json.begin().value()["poses"][0][0][0] = 9; },
          {"poses[0]", "rotation"});
  refused("poses/default/dynamic_poses/.zattrs",
          [](Json& json) { json.begin().value()["timestamps_us"][1] = 0; },
          {"timestamps_us[1]"});
  refused("lidars/top/frames/.zattrs",
          [](Json& json) { json["frames_timestamps_us"][0][1] = 0; },
          {"frames_timestamps_us[0]"});

  NcoreOptions options;
  options.sequence = scratch_ / "a.zarr";
  options.output = scratch_ / "through.log";
  options.lidars = {"top"};
  EXPECT_EQ(import_ncore(options, {}, report_).lidars.size(), 1U);
  options.cameras = {"nose"};
  EXPECT_THROW((void)import_ncore(options, {}, report_), Error);
}

TEST_F(NcoreTest, ReadsRaysWithoutElementsByATable) {
  const Log log = street();
  (void)export_ncore(log, scratch_ / "a.zarr", {});
  strip();
  for (const auto& entry : fs::recursive_directory_iterator(scratch_ / "a.zarr/lidars/top/frames")) {
    if (entry.path().filename() == "model_element") fs::remove(entry.path() / ".zarray");
  }
  fs::remove_all(scratch_ / "a.zarr/intrinsics/default/lidars/top");
  expect_input_error([&] { (void)back("a.zarr"); }, {"lidars/top", "no intrinsics", "--lidar top=SENSOR"});
  NcoreOptions options;
  options.sequence = scratch_ / "a.zarr";
  options.output = scratch_ / "table.log";
  options.tables["top"] = log.lidar("top").with_rows();
  const Log placed = import_ncore(options, {}, report_);
  EXPECT_EQ(report_.points.unplaced, 0U);
  expect_near_sweeps(log, placed);
  options.output.clear();
  test::expect_survey(import_ncore(options, {}, report_), placed);
}

TEST_F(NcoreTest, RefusesDamageInOneLine) {
  const Log log = street();
  (void)export_ncore(log, scratch_ / "a.zarr.itar", {});
  const std::string whole = read_file(scratch_ / "a.zarr.itar");
  std::mt19937 random(11);
  std::size_t refused = 0;
  constexpr std::size_t kRuns = 120;
  for (std::size_t run = 0; run < kRuns; ++run) {
    std::string damaged = whole;
    if (run % 3 == 0) {
      damaged.resize(run * whole.size() / kRuns);
    } else {
      for (std::size_t flips = 0; flips < 1 + run % 7; ++flips)
        damaged[random() % whole.size()] ^= static_cast<char>(1U << random() % 7U);
    }
    (void)scratch_.file("b.zarr.itar", damaged);
    try {
      (void)back("b.zarr.itar");
      EXPECT_NE(run % 3, 0U) << "cut to " << damaged.size();
    } catch (const Error& error) {
      ++refused;
      ASSERT_EQ(error.kind(), ErrorKind::kInput) << error.what();
      ASSERT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  }
  EXPECT_GE(refused, kRuns / 3);
}

TEST(NcorePoses, NamesOfFramesAreReadAsPythonWritesThem) {
  using Pair = std::pair<std::string, std::string>;
  EXPECT_EQ(ncore::frames_of("('rig', 'world')", "f"), Pair("rig", "world"));
  EXPECT_EQ(ncore::frames_of("(\"it's\", 'b')", "f"), Pair("it's", "b"));
  EXPECT_EQ(ncore::frames_of(ncore::key_of("it's", "a\\b"), "f"), Pair("it's", "a\\b"));
  for (const char* bad : {"", "(", "('rig')", "rig, world", "('', 'b')", "('a', 'b"})
    expect_input_error([&] { (void)ncore::frames_of(bad, "f"); }, {"pair of frames"});
}

TEST(NcorePoses, EulerAnglesComeBack) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> angle(-std::numbers::pi, std::numbers::pi);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Quaterniond q =
        ncore::rotation_of_euler({angle(random), 0.5 * angle(random), angle(random)});
    EXPECT_LT(q.angularDistance(ncore::rotation_of_euler(ncore::euler_of(q))), 1e-7);
  }
  const Eigen::Quaterniond up = ncore::rotation_of_euler({0.3, std::numbers::pi / 2, 0.1});
  EXPECT_LT(up.angularDistance(ncore::rotation_of_euler(ncore::euler_of(up))), 1e-7);
}

TEST(NcorePoses, ChainsLinksInEitherDirection) {
  ncore::PoseTable table;
  const auto entry = [](const Pose& pose) {
    Json rows = Json::array();
    const Eigen::Matrix4d m = pose.matrix();
    for (int r = 0; r < 4; ++r) rows.push_back({m(r, 0), m(r, 1), m(r, 2), m(r, 3)});
    return rows;
  };
  const Pose world_from_map{Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ())),
                            {100, 0, 0}},
      rig_from_body{Eigen::Quaterniond::Identity(), {0, 0, 1}},
      body_from_map{Eigen::Quaterniond::Identity(), {1, 2, 3}};
  table.add_static({{"('map', 'world')", {{"pose", entry(world_from_map)}}},
                    {"('body', 'rig')", {{"pose", entry(rig_from_body)}}}},
                   "f");
  table.add_dynamic({{"('map', 'body')", {{"poses", {entry(body_from_map)}}, {"timestamps_us", {5U}}}}}, "f");
  const auto path = table.path("world", "rig");
  ASSERT_EQ(path.size(), 1U);
  const Pose expected = world_from_map * (rig_from_body * body_from_map).inverse();
  EXPECT_TRUE(path[0].pose.matrix().isApprox(expected.matrix(), 1e-12));
  EXPECT_TRUE(table.path("moon", "rig").empty());
}

}  // namespace
}  // namespace simuli::test

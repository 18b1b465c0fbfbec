#include "io/import/nuscenes/nuscenes.hpp"

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <numbers>
#include <string>

#include "io/base/file.hpp"
#include "io/base/json_reader.hpp"
#include "io/import/nuscenes/nuscenes_sweep.hpp"
#include "io/log/camera_mask.hpp"
#include "io/picture/image.hpp"
#include "tests/io/linear.hpp"
#include "tests/io/scratch.hpp"
#include "tests/io/survey.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using test::expect_input_error;
using test::expect_survey;
using test::Scratch;

constexpr int kFirings = 40;

/// Returns a sweep inside a round tower of 10 m around the sensor, which moves 0.1 m along y meanwhile; ring
/// 5 has no return. As in the files, points are in the sensor frame at the end of the sweep.
std::string turn(int firings) {
  std::string bytes;
  const Lidar table = builtin_lidar("nuscenes_lidar_top_hdl32e");
  for (int c = 0; c < firings; ++c) {
    for (int ring = 0; ring < 32; ++ring) {
      const double azimuth = std::numbers::pi * (1.0 - (2.0 * c + 1.0) / kFirings);
      const double elevation = table.rows[static_cast<std::size_t>(31 - ring)].elevation;
      const double flat = ring == 5 ? 0.2 : 10.0;
      const double behind = 0.1 * (1.0 - (c + 0.5) / kFirings);
      for (const double v : {flat * std::cos(azimuth),
                             flat * std::sin(azimuth) - behind,
                             flat * std::tan(elevation),
                             51.0,
                             static_cast<double>(ring)}) {
        const auto value = static_cast<float>(v);
        char four[4];
        std::memcpy(four, &value, 4);
        bytes.append(four, 4);
      }
    }
  }
  return bytes;
}

constexpr std::int64_t kStart_us = 1'532'402'927'600'000;

/// Tables of a data set of two scenes: the first has two samples 0.5 s apart with a camera and the LiDAR, a
/// sweep between them without a file, a radar, and a car that moves 5 m along y.
class DataSet {
 public:
  explicit DataSet(const Scratch& scratch) : root_(scratch.path() / "nuscenes") {
    for (const char* folder : {"v1.0-mini", "samples/CAM_FRONT", "samples/LIDAR_TOP"}) {
      fs::create_directories(root_ / folder);
    }
    table["scene"] = {{{"token", "s0"}, {"name", "scene-0001"}}, {{"token", "s1"}, {"name", "scene-0002"}}};
    table["sample"] = {{{"token", "a"}, {"scene_token", "s0"}, {"timestamp", kStart_us}},
                       {{"token", "b"}, {"scene_token", "s0"}, {"timestamp", kStart_us + 500'000}},
                       {{"token", "z"}, {"scene_token", "s1"}, {"timestamp", kStart_us}}};
    table["sensor"] = {{{"token", "cam"}, {"channel", "CAM_FRONT"}, {"modality", "camera"}},
                       {{"token", "top"}, {"channel", "LIDAR_TOP"}, {"modality", "lidar"}},
                       {{"token", "rad"}, {"channel", "RADAR_FRONT"}, {"modality", "radar"}}};
    table["calibrated_sensor"] = Json::array();
    mount("cc", "cam", {1.7, 0.0, 1.5}, {0.5, -0.5, 0.5, -0.5}, {{9, 0, 4}, {0, 9, 3}, {0, 0, 1}});
    mount("cl", "top", {0.9, 0.0, 1.8}, {std::sqrt(0.5), 0.0, 0.0, -std::sqrt(0.5)}, Json::array());
    mount("cr", "rad", {3.4, 0.0, 0.5}, {1, 0, 0, 0}, Json::array());
    table["sample_data"] = Json::array();
    table["ego_pose"] = Json::array();
    record("a", "cc", "samples/CAM_FRONT/0.jpg", 12'000);
    record("a", "cl", "samples/LIDAR_TOP/0.pcd.bin", 48'000);
    record("a", "cr", "samples/RADAR_FRONT/0.pcd", 30'000);
    record("a", "cl", "sweeps/LIDAR_TOP/absent.pcd.bin", 98'000);
    record("b", "cc", "samples/CAM_FRONT/1.jpg", 512'000);
    record("b", "cl", "samples/LIDAR_TOP/1.pcd.bin", 548'000);
    record("z", "cl", "samples/LIDAR_TOP/2.pcd.bin", 0);
    table["category"] = {{{"token", "car"}, {"name", "vehicle.car"}}};
    table["instance"] = {{{"token", "i"}, {"category_token", "car"}}};
    table["sample_annotation"] = Json::array();
    for (const char* sample : {"b", "a", "b"}) {  // not in time order, one label repeated
      table["sample_annotation"].push_back({{"token", sample},
                                            {"sample_token", sample},
                                            {"instance_token", "i"},
                                            {"translation", {20.0, *sample == 'a' ? 0.0 : 5.0, 0.8}},
                                            {"size", {1.9, *sample == 'a' ? 4.0 : 4.5, 1.6}},
                                            {"rotation", {1, 0, 0, 0}}});
    }
    for (const int i : {0, 1}) {
      Image image(8, 6, 3);
      write_image(root_ / fmt::format("samples/CAM_FRONT/{}.jpg", i), image);
      std::ofstream(root_ / fmt::format("samples/LIDAR_TOP/{}.pcd.bin", i), std::ios::binary)
          << turn(kFirings + i);
    }
  }
  /// Writes the current tables.
  [[nodiscard]] const fs::path& write() const {
    for (const auto& [name, rows] : table.items()) {
      std::ofstream(root_ / "v1.0-mini" / (name + ".json")) << rows.dump();
    }
    return root_;
  }
  Json table = Json::object();

 private:
  void mount(const char* token, const char* sensor, const Json& t, const Json& q, const Json& intrinsic) {
    table["calibrated_sensor"].push_back({{"token", token},
                                          {"sensor_token", sensor},
                                          {"translation", t},
                                          {"rotation", q},
                                          {"camera_intrinsic", intrinsic}});
  }
  /// At time t the ego position is x = 2 m/s t.
  void record(const char* sample, const char* calibration, const std::string& file, std::int64_t us) {
    table["ego_pose"].push_back({{"token", "p" + file},
                                 {"timestamp", kStart_us + us},
                                 {"translation", {1000.0 + 2e-6 * static_cast<double>(us), 0.0, 0.0}},
                                 {"rotation", {1, 0, 0, 0}}});
    table["sample_data"].push_back({{"token", file},
                                    {"sample_token", sample},
                                    {"ego_pose_token", "p" + file},
                                    {"calibrated_sensor_token", calibration},
                                    {"timestamp", kStart_us + us},
                                    {"filename", file},
                                    {"width", 8},
                                    {"height", 6}});
  }
  fs::path root_;
};

TEST(Nuscenes, ASceneBecomesALog) {
  const Scratch scratch;
  const DataSet data(scratch);
  NuscenesReport report;
  const Log log = import_nuscenes({data.write(), "", "scene-0001", scratch / "n.log"}, {}, report);
  NuscenesReport surveyed;
  expect_survey(import_nuscenes({data.write(), "", "scene-0001", ""}, {}, surveyed), log);
  EXPECT_EQ(surveyed.returned, report.returned);
  EXPECT_EQ(report.absent, 1U);
  EXPECT_EQ(report.rays, 2U * 32U * kFirings);
  EXPECT_EQ(report.returned, 2U * 31U * kFirings);
  EXPECT_EQ(log.name, "scene-0001");
  EXPECT_EQ(log.start_ns, 1000 * (kStart_us + 12'000));
  ASSERT_EQ(log.images.size(), 2U);
  ASSERT_EQ(log.sweeps.size(), 2U);
  EXPECT_EQ(log.camera("CAM_FRONT").model.cx, 4.5);
  EXPECT_NEAR(log.images[1].time_start_s, 0.5, 1e-9);
  EXPECT_NEAR(log.sweeps[1].time_end_s, 0.536, 1e-9);
  EXPECT_NEAR(log.sweeps[1].time_end_s - log.sweeps[1].time_start_s, 0.05, 1e-9);
  EXPECT_NEAR(log.world_from_rig.at(0.036).translation.x(), 1000.0 + 2.0 * 0.048, 1e-9);

  const Lidar& lidar = log.lidar("LIDAR_TOP").with_rows();
  EXPECT_EQ(lidar.columns, kFirings);
  const Sweep sweep = read_sweep(log.folder / log.sweeps[0].file, lidar);
  const auto ray = [](int ring, int c) { return static_cast<std::size_t>((31 - ring) * kFirings + c); };
  EXPECT_EQ(sweep.range[ray(5, 3)], 0.0F);
  EXPECT_NEAR(sweep.rays.azimuth[ray(5, 3)], lidar.azimuth(0, 3), 1e-4);
  EXPECT_NEAR(sweep.range[ray(0, 3)] * std::cos(sweep.rays.elevation[ray(0, 3)]), 10.0, 1e-3);
  EXPECT_NEAR(sweep.intensity[ray(0, 3)], 0.2, 1e-4);

  ASSERT_EQ(log.actors.size(), 1U);
  EXPECT_EQ(log.actors[0].name, "car_0");
  EXPECT_EQ(log.actors[0].size_m, Eigen::Vector3d(4.5, 1.9, 1.6));  // the median of 4.5, 4 and 4.5 m
  EXPECT_EQ(log.actors[0].track.size(), 2U);
  EXPECT_EQ(report.labels.kept, 2U);
  EXPECT_EQ(report.labels.repeated, 1U);
  EXPECT_NEAR(log.actors[0].at(0.238).translation.y(), 2.5, 1e-6);

  fs::create_directories(data.write() / "sweeps/LIDAR_TOP/absent.pcd.bin");
  expect_input_error(
      [&] {
        (void)import_nuscenes({data.write(), "", "scene-0001", scratch / "x.log"}, {}, report);
      },
      {"absent.pcd.bin: file: found a folder"});
}

TEST(Nuscenes, VehicleInTheBackCameraIsHidden) {
  const Scratch scratch;
  DataSet data(scratch);
  NuscenesReport report;
  const Log front = import_nuscenes({data.write(), "", "scene-0001", scratch / "f.log"}, {}, report);
  EXPECT_TRUE(front.hidden.empty() && report.hidden.empty());
  data.table["sensor"][0]["channel"] = "CAM_BACK";
  const Log back = import_nuscenes({data.write(), "", "scene-0001", scratch / "b.log"}, {}, report);
  EXPECT_NEAR(back.hidden.at("CAM_BACK")->hidden_share(), 1.0 / 6.0, 1e-9);  // 80 of 900 rows, of 6
  ASSERT_EQ(report.hidden.size(), 1U);
  EXPECT_EQ(report.hidden[0], "CAM_BACK: rows 5 to 5 show the vehicle and are hidden");
}

TEST(Nuscenes, TablesAreReadInProportionToTheirLength) {
  const Scratch scratches[2];
  fs::path roots[2];
  for (const int which : {0, 1}) {
    DataSet data(scratches[which]);
    for (const char* name : {"ego_pose", "sample_data"}) {
      Json entry = data.table[name].back();  // of the other scene
      for (int i = 0; i < 15'000 * (which + 1); ++i) {
        entry["token"] = std::to_string(i);
        data.table[name].push_back(entry);
      }
    }
    roots[which] = data.write();
  }
  NuscenesReport report;
  test::expect_linear([&](int which) {
    (void)import_nuscenes({roots[which], "", "scene-0001", ""}, {}, report);
  });
}

TEST(Nuscenes, SaysWhatDoesNotFit) {
  const Scratch scratch;
  NuscenesReport report;
  const auto refuse =
      [&](const DataSet& data, const std::string& scene, const std::vector<std::string>& words) {
        expect_input_error(
            [&] {
              (void)import_nuscenes({data.write(), "", scene, scratch / "x.log"}, {}, report);
            },
            words);
        EXPECT_FALSE(fs::exists(scratch / "x.log"));
      };
  DataSet data(scratch);
  refuse(data, "", {"scene.json", "scene-0001, scene-0002"});
  refuse(data, "scene-9", {"scene-9"});
  DataSet dangling(scratch);
  dangling.table["sample_data"][1]["calibrated_sensor_token"] = "none";
  refuse(dangling, "scene-0001", {"sample_data.json", "[1].calibrated_sensor_token"});
  DataSet flat(scratch);
  flat.table["calibrated_sensor"][0]["camera_intrinsic"] = Json::array();
  refuse(flat, "scene-0001", {"[0].camera_intrinsic"});
  expect_input_error(
      [&] {
        (void)import_nuscenes({scratch.path(), "", "", scratch / "x.log"}, {}, report);
      },
      {"folders of tables", "none"});
  const std::string whole = turn(kFirings);
  const fs::path file = scratch.file("t.bin", whole);
  const Lidar lidar = nuscenes::lidar_of({file}, "LIDAR_TOP");
  const auto refuse_turn = [&](const std::string& bytes, const char* word) {
    expect_input_error([&] { (void)nuscenes::read_turn(scratch.file("b.bin", bytes), lidar, {}); },
                       {"b.bin", word});
  };
  refuse_turn(whole.substr(20), "size");
  refuse_turn(whole.substr(640), "firings");
  refuse_turn(whole.substr(20) + whole.substr(0, 20), "ring");
}

TEST(Nuscenes, ARealTurnIsAWholeGrid) {
  const char* const data = std::getenv("SIMULI_DATA");
  if (data == nullptr) GTEST_SKIP() << "not run: a key frame of nuScenes, SIMULI_DATA is not set";
  const fs::path folder = fs::path(data) / "nuscenes_keyframe";
  fs::path file;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().string().ends_with(".pcd.bin")) file = entry.path();
  }
  const Lidar lidar = nuscenes::lidar_of({file}, "LIDAR_TOP");
  EXPECT_EQ(lidar.columns, 1084);
  // The car moved at 8.4 m/s; y is forward.
  const Pose start_from_end{Eigen::Quaterniond::Identity(), {0.0, 0.42, 0.0}};
  const Sweep sweep = nuscenes::read_turn(file, lidar, start_from_end);
  // Projects the LiDAR's points to the front camera by the key frame's calibration: the points at the horizon
  // must be ahead of the car.
  const Json calibration = parse_json(read_file(folder / "images_calib.json"), "images_calib.json");
  Eigen::Matrix<double, 3, 4> m;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 4; ++c) {
      m(r, c) = calibration.at("CAM_FRONT")
                    .at("lidar2cam")[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)];
    }
  }
  const Pose camera_from_lidar = Pose::from_matrix(m);
  std::size_t returned = 0, ahead = 0;
  double farthest_turn = 0.0;
  for (std::size_t i = 0; i < sweep.range.size(); ++i) {
    const int row = static_cast<int>(i / 1084), column = static_cast<int>(i % 1084);
    farthest_turn = std::max(farthest_turn, std::abs(sweep.rays.azimuth[i] - lidar.azimuth(row, column)));
    if (sweep.range[i] == 0.0F) continue;
    ++returned;
    const Eigen::Vector3d p =
        camera_from_lidar * (static_cast<double>(sweep.range[i]) *
                             Lidar::direction(sweep.rays.azimuth[i], sweep.rays.elevation[i]));
    const double fx = 1266.4, x = fx * p.x() / p.z() + 816.3, y = fx * p.y() / p.z() + 491.5;
    if (p.z() > 1.0 && x > 0.0 && x < 1600.0 && y > 0.0 && y < 900.0) ++ahead;
  }
  EXPECT_GT(returned, 24000U);
  EXPECT_LT(returned, 28000U);
  EXPECT_NEAR(static_cast<double>(ahead), 3300.0, 800.0);  // a sixth of the sweep, half of the beams
  EXPECT_LT(farthest_turn, 0.03);  // the spin is uniform and starts at the table's azimuth
}

}  // namespace
}  // namespace simuli

#include "io/export/drive_archive.hpp"

#include <cstring>
#include <gtest/gtest.h>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "host/core/sensors/lidar_library.hpp"
#include "io/base/file.hpp"
#include "io/export/ftheta_camera.hpp"
#include "io/export/track_labels.hpp"
#include "io/scene/scene_clock.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

using test::expect_input_error;
using test::Scratch;
using Json = nlohmann::ordered_json;

/// Returns the files of a zip without compression, each at a multiple of 64.
std::map<std::string, std::string> files_of(const std::string& zip) {
  std::map<std::string, std::string> out;
  const auto number = [&](std::size_t at, std::size_t bytes) {
    std::uint32_t value = 0;
    std::memcpy(&value, zip.data() + at, bytes);
    return value;
  };
  for (std::size_t at = 0; zip.compare(at, 4, "PK\x03\x04") == 0;) {
    const std::size_t name = number(at + 26, 2), from = at + 30 + name + number(at + 28, 2);
    EXPECT_EQ(number(at + 8, 2), 0U);
    EXPECT_EQ(from % 64, 0U);
    out[zip.substr(at + 30, name)] = zip.substr(from, number(at + 18, 4));
    at = from + number(at + 18, 4);
  }
  return out;
}

/// Returns a trajectory of two poses far from the world origin, a rolling-shutter camera, a car with three
/// poses and a box with one, and flat ground.
SceneFile small_drive() {
  SceneFile file;
  file.scene.name = "drive";
  file.scene.origin = {500'000.0, 4'000'000.0, 100.0};
  Camera camera;
  camera.name = "front";
  camera.width = 64;
  camera.height = 32;
  camera.cx = 30.5;
  camera.cy = 16.25;
  camera.shutter = ShutterKind::kTopToBottom;
  set_ftheta(camera, LensKind::kFtheta, {40.0, 0.0, -1.5, 0.0, 0.0}, {1.0, 0.0, 0.0}, 1.2);
  const Pose mounted{Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), {1.5, 0.0, 1.6}};
  file.cameras.push_back({camera, mounted});
  file.lidars.push_back({builtin_lidar("hesai_xt32"), {}});
  const Eigen::Vector3d o = file.scene.origin;
  const Eigen::Quaterniond left(Eigen::AngleAxisd(M_PI / 2.0, Eigen::Vector3d::UnitZ()));
  file.world_from_rig = Trajectory(
      {{-0.5, {Eigen::Quaterniond::Identity(), o}}, {1.0, {left, o + Eigen::Vector3d(10.0, 0.0, 0.5)}}});
  file.recorded_frames["front"] = {{0.1, 0.13}, {0.2, 0.2}};
  Actor car{"car", "vehicle", {4.0, 2.0, 1.5}, {}};
  for (const double time_s : {0.0, 0.1, 0.1000001}) {
    car.track.push_back({time_s, {left, o + Eigen::Vector3d(3.0, 4.0 + time_s, 0.75)}});
  }
  car.track[1].shift_m = {0.0, 0.0, 0.25};
  Actor box{"box", "", {1.0, 1.0, 1.0}, {{0.2, {Eigen::Quaterniond::Identity(), o}}}};
  Actor nowhere = box;
  nowhere.name = "nowhere";
  nowhere.track.clear();
  file.scene.actors = {car, box, nowhere};
  constexpr int kSide = 20;
  file.scene.lidar = GaussianSet(SetKind::kLidar, 0, kSide * kSide);
  for (int i = 0; i < kSide * kSide; ++i) {
    file.scene.lidar.mean().row(i) << static_cast<float>(i % kSide) - 4.5F,
        static_cast<float>(i / kSide) - 9.5F, 0.0F;
    file.scene.lidar.rotation()(i, 0) = 1.0F;
    file.scene.lidar.opacity_logit()(i) = 3.0F;
  }
  return file;
}

TEST(DriveArchive, TellsWhatTheRuntimeReads) {
  const Scratch scratch;
  const DriveArchive reported = write_drive_archive(scratch / "a.usdz", small_drive(), "drive");
  EXPECT_EQ(reported.actors, 2U);
  EXPECT_EQ(reported.cameras_without_model, 0U);
  const std::string zip = read_file(scratch / "a.usdz");
  EXPECT_EQ(zip.substr(30, 11), "splats.usda");  // readers of USD need a layer first
  const auto files = files_of(zip);
  EXPECT_EQ(files.size(), 8U);

  const std::string& metadata = files.at("metadata.yaml");
  for (const char* line : {"scene_id: \"drive\"\n",
                           "is_resumable: false\n",
                           "sensors: {\"camera_ids\":[\"front\"],\"lidar_ids\":[\"hesai_xt32\"]}\n",
                           "time_range: {\"start\":500000.0,\"end\":2000000.0}\n",
                           "training_step_outputs: {}\n"}) {
    EXPECT_NE(metadata.find(line), std::string::npos) << line << metadata;
  }

  const Json rig = Json::parse(files.at("rig_trajectories.json"));
  const Json identity =
      Json::parse("[[1.0,0.0,0.0,0.0],[0.0,1.0,0.0,0.0],[0.0,0.0,1.0,0.0],[0.0,0.0,0.0,1.0]]");
  EXPECT_EQ(rig.at("world_to_nre").at("matrix"), identity);
  const Json& path = rig.at("rig_trajectories").at(0);
  EXPECT_EQ(path.at("sequence_id"), "drive");
  EXPECT_EQ(path.at("T_rig_worlds").at(0), identity);  // m relative to the scene origin
  EXPECT_EQ(path.at("T_rig_worlds").at(1).at(0).at(3), 10.0);
  EXPECT_NEAR(path.at("T_rig_worlds").at(1).at(1).at(0).get<double>(), 1.0, 1e-12);
  // The trajectory starts half a second before the log: all times are shifted by one second.
  EXPECT_EQ(path.at("T_rig_world_timestamps_us"), Json::array({500000, 2000000}));
  EXPECT_EQ(path.at("cameras_frame_timestamps_us").at("front"),
            Json::parse("[[1100000, 1130000], [1200000, 1200001]]"));
  EXPECT_TRUE(path.at("rig_bbox").is_null());
  const Json& camera = rig.at("camera_calibrations").at("front");
  EXPECT_EQ(camera.at("logical_sensor_name"), "front");
  EXPECT_EQ(camera.at("T_sensor_rig").at(0), Json::array({0.0, 0.0, 1.0, 1.5}));  // points along the rig's x
  EXPECT_EQ(camera.at("camera_model").at("type"), "ftheta");
  const Json& model = camera.at("camera_model").at("parameters");
  EXPECT_EQ(model.at("resolution"), Json::array({64, 32}));
  EXPECT_EQ(model.at("shutter_type"), "ROLLING_TOP_TO_BOTTOM");
  // relative to the centre of the first pixel
  EXPECT_EQ(model.at("principal_point"), Json::array({30.0, 15.75}));
  EXPECT_EQ(model.at("reference_poly"), "ANGLE_TO_PIXELDIST");
  const std::vector<double> degrees{0.0, 40.0, 0.0, -1.5, 0.0, 0.0};
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_NEAR(model.at("angle_to_pixeldist_poly").at(i).get<double>(), degrees[i], 1e-12);
  EXPECT_EQ(model.at("linear_cde"), Json::array({1.0, 0.0, 0.0}));

  const Json tracks = Json::parse(files.at("sequence_tracks.json")).at("dummy_chunk_id");
  const Json& data = tracks.at("tracks_data");
  EXPECT_EQ(data.at("tracks_id"), Json::array({"car", "box"}));
  EXPECT_EQ(data.at("tracks_label_class"), Json::array({"automobile", ""}));
  EXPECT_EQ(data.at("tracks_flags"), Json::parse(R"([["CONTROLLABLE", "DYNAMIC"], ["CONTROLLABLE"]])"));
  EXPECT_EQ(data.at("tracks_timestamps_us"), Json::parse("[[1000000, 1100000], [1200000, 1300000]]"));
  const Json& pose = data.at("tracks_poses").at(0).at(1);
  const std::vector<double> expected{3.0, 4.1, 1.0, 0.0, 0.0, std::sqrt(0.5), std::sqrt(0.5)};
  for (std::size_t i = 0; i < 7; ++i) EXPECT_NEAR(pose.at(i).get<double>(), expected[i], 1e-6) << i;
  EXPECT_EQ(tracks.at("cuboidtracks_data").at("cuboids_dims").at(0), Json::array({4.0, 2.0, 1.5}));

  const std::string& map = files.at("map.xodr");
  EXPECT_NE(map.find("x=\"0.000000000\" y=\"0.000000000\""), std::string::npos) << map;
  EXPECT_NE(map.find("a=\"0.000000\""), std::string::npos);  // the ground, 0.5 m below the trajectory

  const Json info = Json::parse(files.at("data_info.json"));
  EXPECT_EQ(info.at("pose-range").at("end-timestamp_us"), 2000000);
  EXPECT_EQ(reported.ground_triangles, 2U * 19U * 19U);
  const std::string& mesh = files.at("mesh_ground.ply");
  EXPECT_EQ(files.at("mesh.ply"), mesh);
  EXPECT_NE(mesh.find("element vertex 400\n"), std::string::npos);
  EXPECT_NE(mesh.find("element face 722\nproperty list uchar int vertex_indices\n"), std::string::npos);
  EXPECT_EQ(mesh.size(), mesh.find("end_header\n") + 11 + 400 * 12 + 722 * 13);
}

TEST(DriveArchive, EveryCameraTellsWhatCarlaReads) {
  SceneFile scene = small_drive();
  Camera camera = scene.cameras.front().model;
  camera.name = "pinhole";
  camera.lens = {};
  scene.cameras.push_back({camera, {}});
  camera.name = "round";
  camera.lens = Lens(LensKind::kEquirectangular, {});
  scene.cameras.push_back({camera, {}});
  const Scratch scratch;
  EXPECT_EQ(write_drive_archive(scratch / "a.usdz", scene, "a").cameras_without_model, 1U);
  const Json rig = Json::parse(files_of(read_file(scratch / "a.usdz")).at("rig_trajectories.json"));
  const Json& cameras = rig.at("camera_calibrations");
  EXPECT_EQ(cameras.at("pinhole").at("camera_model").at("type"), "opencv-pinhole");
  EXPECT_EQ(cameras.at("round").at("camera_model").at("type"), "unknown");
  for (const Json& one : cameras) {
    for (const char* key : {"resolution",
                            "shutter_type",
                            "external_distortion_parameters",
                            "principal_point",
                            "reference_poly",
                            "pixeldist_to_angle_poly",
                            "angle_to_pixeldist_poly",
                            "max_angle",
                            "linear_cde"}) {
      EXPECT_TRUE(one.at("camera_model").at("parameters").contains(key)) << key;
    }
  }
}

TEST(DriveArchive, BothPolynomialsAreOneLens) {
  Camera camera = small_drive().cameras.front().model;
  const auto value = [](const std::array<double, 6>& p, double x) {
    double sum = 0.0;
    for (std::size_t i = 6; i-- > 0;) sum = sum * x + p[i];
    return sum;
  };
  for (const bool inverse : {false, true}) {
    if (inverse)
      set_ftheta(camera, LensKind::kFthetaInverse, {0.025, 0.0, 1e-6, 0.0, 0.0}, {1.0, 0.0, 0.0}, 1.2);
    const FthetaCamera ftheta = ftheta_of(camera);
    EXPECT_EQ(ftheta.is_inverse, inverse);
    for (double angle = 0.05; angle < 0.85; angle += 0.1) {
      const double radius = value(ftheta.angle_to_pixels, angle);
      EXPECT_NEAR(value(ftheta.pixels_to_angle, radius), angle, 1e-4);
      Eigen::Vector2d pixel;
      ASSERT_TRUE(camera.project({0.0, std::sin(angle), std::cos(angle)}, pixel));
      EXPECT_NEAR(pixel.y() - camera.cy, radius, 0.01);
      EXPECT_NEAR(pixel.x(), ftheta.principal_point[0] + 0.5, 1e-9);
    }
  }
}

TEST(DriveArchive, RefusesWhatIsNoDrive) {
  const Scratch scratch;
  SceneFile scene = small_drive();
  expect_input_error([&] { write_drive_archive(scratch / "a.zip", scene, "a"); }, {"a.zip", ".usdz"});
  scene.cameras.clear();
  expect_input_error([&] { write_drive_archive(scratch / "a.usdz", scene, "a"); }, {"a.usdz", "cameras"});
  scene.world_from_rig = {};
  expect_input_error([&] { write_drive_archive(scratch / "a.usdz", scene, "a"); }, {"a.usdz", "path"});
  EXPECT_FALSE(std::filesystem::exists(scratch / "a.usdz"));
  SceneFile floating = small_drive();
  floating.scene.lidar.opacity_logit().setConstant(-3.0F);  // no solid surface
  EXPECT_EQ(write_drive_archive(scratch / "f.usdz", floating, "f").ground_triangles, 0U);
  EXPECT_EQ(files_of(read_file(scratch / "f.usdz")).count("mesh_ground.ply"), 0U);
  EXPECT_EQ(files_of(read_file(scratch / "f.usdz")).count("mesh.ply"), 0U);
}

TEST(TrackLabels, SayWhatCarlaCallsIt) {
  const std::map<std::string, std::string> expected{
      {"car", "automobile"},
      {"Car", "automobile"},
      {"vehicle", "automobile"},
      {"vehicle.bus.rigid", "bus"},
      {"vehicle.truck", "heavy_truck"},
      {"Person_sitting", "person"},
      {"human.pedestrian.adult", "person"},
      {"Cyclist", "rider"},
      {"vehicle.trailer", "trailer"},
      {"automobile", "automobile"},
      {"train_or_tram_car", "train_or_tram_car"},
      {"static_object.bicycle_rack", "static_object.bicycle_rack"},
      {"", ""},
      {"cart", "cart"}};
  for (const auto& [kind, label] : expected) EXPECT_EQ(label_class_of(kind), label) << kind;
}

TEST(SceneClock, CountsMicrosecondsOfThePath) {
  const SceneClock clock(Trajectory({{-1.2, {}}, {3.0, {}}}));
  EXPECT_EQ(clock.microseconds(-1.2), 800'000U);
  EXPECT_EQ(clock.microseconds(0.0000014), 2'000'001U);
  EXPECT_EQ(clock.microseconds(-5.0), 0U);
  EXPECT_DOUBLE_EQ(clock.seconds(800'000), -1.2);
  EXPECT_EQ(SceneClock(Trajectory{}).microseconds(1.0), 1'000'000U);
  EXPECT_EQ(scene_id_of("x/drive.scene/"), "drive");
  EXPECT_EQ(scene_id_of("drive.ply"), "drive");
}

}  // namespace
}  // namespace simuli

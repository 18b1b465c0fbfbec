#include <gtest/gtest.h>
#include <string>

#include "io/log/sensor_json.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace sensor_file_test {

using test::expect_input_error;
using test::Scratch;

void expect_same(const Lidar& a, const Lidar& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.columns, b.columns);
  EXPECT_EQ(a.azimuth_first, b.azimuth_first);
  EXPECT_EQ(a.azimuth_span, b.azimuth_span);
  EXPECT_EQ(a.spin, b.spin);
  EXPECT_EQ(a.range_min, b.range_min);
  EXPECT_EQ(a.range_max, b.range_max);
  EXPECT_EQ(a.beam_divergence, b.beam_divergence);
  EXPECT_EQ(a.divergence_variance, b.divergence_variance);
  EXPECT_EQ(a.sweep_s, b.sweep_s);
  ASSERT_EQ(a.rows.size(), b.rows.size());
  for (std::size_t r = 0; r < a.rows.size(); ++r) {
    EXPECT_EQ(a.rows[r].elevation, b.rows[r].elevation);
    EXPECT_EQ(a.rows[r].azimuth_offset, b.rows[r].azimuth_offset);
    EXPECT_EQ(a.rows[r].vertical_offset, b.rows[r].vertical_offset);
    EXPECT_EQ(a.rows[r].horizontal_offset, b.rows[r].horizontal_offset);
    EXPECT_EQ(a.rows[r].time_offset, b.rows[r].time_offset);
    EXPECT_EQ(a.rows[r].radial_offset, b.rows[r].radial_offset);
    EXPECT_EQ(a.rows[r].range_bias, b.rows[r].range_bias);
  }
}

LidarFile some_file() {
  const BuiltinLidar sensor = builtin_lidar_with_facts("ouster_os1_32_g@2048x10");
  return {sensor.model, sensor.facts};
}

LidarFile some_rays() {
  RayList list;
  list.name = "petals";
  list.azimuth = {0.1, -0.2, 0.3};
  list.elevation = {0.0, 0.05, -0.1};
  list.time_fraction = {0.0, 0.25, 0.5};
  list.origin = {{0.0, 0.01, 0.02}, {0.0, 0.0, 0.0}, {-0.1, 0.0, 0.0}};
  list.range_min = 0.5;
  list.range_max = 60.0;
  return {list, {}};
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

TEST(LidarFile, EveryBuiltInModelRoundTrips) {
  const Scratch scratch;
  for (const std::string& name : builtin_lidar_names()) {
    const BuiltinLidar sensor = builtin_lidar_with_facts(name);
    const LidarFile read =
        read_lidar_file(scratch.file("sensor.json", to_json(LidarFile{sensor.model, sensor.facts}).dump(1)));
    expect_same(std::get<Lidar>(read.model), sensor.model);
    EXPECT_EQ(read.facts.source, sensor.facts.source);
    EXPECT_EQ(read.facts.licence, sensor.facts.licence);
    EXPECT_EQ(read.facts.note, sensor.facts.note);
    EXPECT_EQ(read.facts.modes.size(), sensor.facts.modes.size());
  }
}

TEST(LidarFile, TheModelsOwnModeStandsFirst) {
  const Scratch scratch;
  const LidarFile read = read_lidar_file(scratch.file("sensor.json", to_json(some_file()).dump()));
  EXPECT_EQ(read.facts.mode.columns, 2048);
  EXPECT_EQ(read.facts.mode.spin_hz, 10.0);
  EXPECT_EQ(read.facts.modes.size(), 5U);
}

TEST(LidarFile, TurnTakesWhatTheFileSays) {
  const Scratch scratch;
  const auto sweep_of = [&](const std::string& text) {
    return sweep_s(read_lidar_file(scratch.file("sensor.json", text)).model);
  };
  const BuiltinLidar fast = builtin_lidar_with_facts("hesai_xt32@20");
  const std::string text = to_json({fast.model, fast.facts}).dump();
  EXPECT_EQ(sweep_of(text), 0.05);
  EXPECT_EQ(sweep_of(replaced(text, ",\"sweep_s\":0.05", "")), 0.05);  // its first mode
  EXPECT_EQ(sweep_of(replaced(text, "\"sweep_s\":0.05", "\"sweep_s\":0.04")), 0.04);
  LidarFile rays = some_rays();
  EXPECT_EQ(to_json(rays).count("sweep_s"), 0U);
  EXPECT_EQ(sweep_of(to_json(rays).dump()), 0.1);
  std::get<RayList>(rays.model).sweep_s = 0.2;
  EXPECT_EQ(sweep_of(to_json(rays).dump()), 0.2);
  expect_input_error([&] { (void)sweep_of(replaced(text, "\"sweep_s\":0.05", "\"sweep_s\":0")); },
                     {"sweep_s", "0", "above 0"});
}

TEST(LidarFile, BlindArcsRoundTrip) {
  const Scratch scratch;
  LidarFile file = some_file();
  auto& model = std::get<Lidar>(file.model);
  model.blind = {{0, 0.1, 0.2}, {0, 3.0, 6.25, true}, {1, 0.0, 0.5}};
  const LidarFile read = read_lidar_file(scratch.file("sensor.json", to_json(file).dump()));
  const std::vector<BlindArc>& arcs = std::get<Lidar>(read.model).blind;
  ASSERT_EQ(arcs.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(arcs[i].row, model.blind[i].row);
    EXPECT_EQ(arcs[i].azimuth_first, model.blind[i].azimuth_first);
    EXPECT_EQ(arcs[i].azimuth_last, model.blind[i].azimuth_last);
    EXPECT_EQ(arcs[i].own_returns, model.blind[i].own_returns);
  }
}

TEST(LidarFile, RayListRoundTrips) {
  const Scratch scratch;
  const LidarFile written = some_rays();
  const LidarFile read = read_lidar_file(scratch.file("rays.json", to_json(written).dump()));
  const auto& a = std::get<RayList>(read.model);
  const auto& b = std::get<RayList>(written.model);
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.azimuth, b.azimuth);
  EXPECT_EQ(a.elevation, b.elevation);
  EXPECT_EQ(a.time_fraction, b.time_fraction);
  EXPECT_EQ(a.origin, b.origin);
  EXPECT_EQ(a.range_max, 60.0);
  LidarFile plain = some_rays();
  std::get<RayList>(plain.model).origin.clear();
  EXPECT_EQ(to_json(plain).count("origin_m"), 0U);
  const LidarFile again = read_lidar_file(scratch.file("plain.json", to_json(plain).dump()));
  EXPECT_TRUE(std::get<RayList>(again.model).origin.empty());
}

TEST(LidarFile, BadFilesAreRefusedByField) {
  const Scratch scratch;
  const std::string good = to_json(some_file()).dump();
  const auto refused = [&](const std::string& text, const std::vector<std::string>& words) {
    expect_input_error([&] { (void)read_lidar_file(scratch.file("bad.json", text)); }, words);
  };
  refused("{", {"bad.json"});
  refused("[]", {"bad.json"});
  refused(replaced(good, "\"lidar\"", "\"radar\""), {"bad.json: kind", "radar", "lidar or ray_list"});
  refused(replaced(good, "\"clockwise\"", "\"left\""), {"spin", "left", "clockwise"});
  refused(replaced(good, "range_max_m", "range_max_cm"), {"range_max_m"});
  refused(replaced(good, "\"rows\"", "\"colour\": 1, \"rows\""), {"colour"});
  refused(replaced(good, "\"elevation_rad\"", "\"elevation_deg\""), {"rows[0].elevation_rad"});
  refused(replaced(good, "\"elevation_rad\":", "\"elevation_rad\":7"), {"rows[0].elevation_rad", "7"});
  refused(replaced(good, "\"columns\":2048,\"azimuth_first_rad\"", "\"columns\":2047,\"azimuth_first_rad\""),
          {"modes[0].columns", "2048", "2047"});
  expect_input_error([&] { (void)read_lidar_file(scratch / "none.json"); }, {"none.json"});

  const std::string rays = to_json(some_rays()).dump();
  refused(replaced(rays, "[0.0,0.05,-0.1]", "[0.0,0.05]"), {"elevation_rad", "2 rays"});
  refused(replaced(rays, "\"origin_m\":[", "\"origin_m\":[1,"), {"origin_m", "10 numbers"});
  refused(replaced(rays, "\"range_min_m\":0.5", "\"range_min_m\":-1"), {"range_min_m", "-1"});
}

TEST(LidarFile, OlderLogsHaveNeitherKindNorRadialOffset) {
  Lidar model = builtin_lidar("velodyne_vlp16");
  Json json = to_json(model);
  for (Json& row : json["rows"]) row.erase("radial_offset_m");
  json.erase("kind");
  const LidarModel read = read_json_text(json.dump(), "log.json", lidar_model_from_json);
  expect_same(std::get<Lidar>(read), model);
}

CameraFile some_camera() {
  Camera camera{"wide", 640, 480, 200.5, 201.25, 320.5, 239.75};
  camera.lens = Lens(LensKind::kOpencvFisheye, {0.02, 0.01, 0.005, 0.002, 1.8});
  camera.shutter = ShutterKind::kTopToBottom;
  return {camera, 0.03, "a bench", "CC0", "of a made-up sensor"};
}

TEST(CameraFile, EveryBuiltInModelRoundTrips) {
  const Scratch scratch;
  for (const std::string& name : builtin_camera_names()) {
    const CameraFile written{builtin_camera(name), 0.0, builtin_camera_source(name)};
    write_sensor_file(scratch / "camera.json", written);
    const CameraFile read = read_camera_file(scratch / "camera.json");
    EXPECT_EQ(read.model, written.model) << name;
    EXPECT_EQ(read.source, written.source);
    EXPECT_EQ(to_json(read).dump(), to_json(written).dump());
  }
}

TEST(CameraFile, SaysHowLongItReadsOut) {
  const Scratch scratch;
  write_sensor_file(scratch / "wide.json", some_camera());
  const CameraFile read = read_camera_file(scratch / "wide.json");
  EXPECT_EQ(read.model, some_camera().model);
  EXPECT_EQ(read.licence, "CC0");
  EXPECT_EQ(read.note, "of a made-up sensor");
  const Sensor sensor = sensor_of(read_sensor_file(scratch / "wide.json"));
  EXPECT_TRUE(sensor.is_camera());
  EXPECT_EQ(sensor.duration_s(), 0.03);
  EXPECT_EQ(std::get<CameraFile>(sensor_file_of(sensor)).readout_s, 0.03);
  CameraFile still = some_camera();
  still.model.shutter = ShutterKind::kGlobal;
  EXPECT_EQ(std::get<CameraFile>(sensor_file_of(Sensor(still.model, {}, 0.01))).readout_s, 0.0);
  expect_input_error([&] { write_sensor_file(scratch / "still.json", still); },
                     {"still.json: readout_s: found 0.03 with a global shutter"});
}

TEST(CameraFile, BadFilesAreRefusedByField) {
  const Scratch scratch;
  const std::string good = to_json(some_camera()).dump();
  const auto refused = [&](const std::string& text, const std::vector<std::string>& words) {
    expect_input_error([&] { (void)read_camera_file(scratch.file("bad.json", text)); }, words);
  };
  refused(replaced(good, "\"kind\":\"camera\",", ""), {"bad.json: kind"});
  refused(replaced(good, "\"camera\"", "\"radar\""),
          {"bad.json: kind", "radar", "camera, lidar or ray_list"});
  refused(replaced(good, "opencv_fisheye", "fov"), {"bad.json: model", "fov", "pinhole"});
  refused(replaced(good, "\"fx_px\"", "\"fx_m\""), {"fx_px"});
  refused(replaced(good, "\"fx_px\":200.5", "\"fx_px\":0"), {"bad.json", "fx_px", "found 0", "0.64 to"});
  refused(replaced(good, "\"k2\"", "\"k9\""), {"k2"});
  refused(replaced(good, "top_to_bottom", "rolling"), {"shutter", "rolling", "top_to_bottom"});
  refused(replaced(good, "top_to_bottom", "global"), {"readout_s", "0.03 with a global shutter"});
  refused(replaced(good, "\"readout_s\":0.03", "\"readout_s\":-1"), {"readout_s", "-1"});
  refused(to_json(some_file()).dump(), {"bad.json: kind: found a LiDAR, allowed camera"});
  expect_input_error([&] { (void)read_lidar_file(scratch.file("bad.json", good)); },
                     {"bad.json: kind: found a camera, allowed lidar or ray_list"});
}

}  // namespace sensor_file_test
}  // namespace simuli

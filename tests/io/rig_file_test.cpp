#include "io/scene/rig_file.hpp"

#include <gtest/gtest.h>

#include "host/core/scene/mounting.hpp"
#include "io/log/log_json.hpp"
#include "io/log/sensor_json.hpp"
#include "tests/io/scratch.hpp"
#include "tests/support/scenes.hpp"

namespace simuli {
namespace rig_file_test {

using test::expect_input_error;
using test::Scratch;

Pose at(double x) { return {Eigen::Quaterniond::Identity(), {x, 0.0, 0.0}}; }

SensorRig recorded() {
  SceneFile file;
  Camera camera = test::small_camera(8, 6);
  camera.name = "front";
  file.cameras.push_back({camera, at(1.0)});
  Lidar lidar = test::small_lidar(4, 20);
  lidar.name = "top";
  file.lidars.push_back({lidar, at(2.0)});
  file.recorded_frames = {{"front", {{0.0, 0.02}}}, {"top", {{0.0, 0.1}}}};
  return SensorRig(file);
}

Json rig_of(const Json& sensors) { return {{"format", "simuli rig"}, {"version", 1}, {"sensors", sensors}}; }

TEST(RigFile, SensorsStandWhereItSays) {
  const Scratch scratch;
  write_sensor_file(scratch / "wide.json", CameraFile{builtin_camera("tum_vi_cam0")});
  const Json own = to_json(LidarFile{builtin_lidar("velodyne_vlp16")});
  const Pose turned = Mounting{{0.5, 0.0, 2.0}, 0.0, 0.0, 90.0}.rig_from_lidar();
  const auto file =
      scratch.file("rig.json",
                   rig_of({{{"name", "a"}, {"sensor", "front"}},
                           {{"name", "b"}, {"sensor", "hesai_xt32@20"}},
                           {{"name", "c"},
                            {"sensor", "tum_vi_cam0"},
                            {"mount", {{"position_m", {0.1, 0.2, 1.5}}, {"pitch_deg", 10}, {"yaw_deg", -90}}},
                            {"width_px", 64},
                            {"height_px", 32},
                            {"readout_s", 0.03}},
                           {{"name", "d"}, {"sensor", "wide.json"}},
                           {{"name", "e"}, {"sensor", own}, {"rig_from_sensor", to_json(turned)}},
                           {{"name", "f"}, {"sensor", own}}})
                       .dump());
  const std::vector<RigSensor> rig = read_rig_file(file, recorded());
  ASSERT_EQ(rig.size(), 6U);
  for (std::size_t i = 0; i < rig.size(); ++i) EXPECT_EQ(rig[i].sensor.name(), std::string(1, "abcdef"[i]));
  EXPECT_EQ(rig[0].model, "front");
  EXPECT_EQ(rig[0].sensor.rig_from_sensor().translation.x(), 1.0);
  EXPECT_EQ(rig[0].sensor.duration_s(), 0.02);
  EXPECT_EQ(rig[1].sensor.rig_from_sensor().translation.x(), 2.0);
  EXPECT_EQ(rig[1].sensor.duration_s(), 0.05);
  const Sensor& mounted = rig[2].sensor;
  const Pose expected = Mounting{{0.1, 0.2, 1.5}, 0.0, 10.0, -90.0}.rig_from_camera();
  EXPECT_EQ(mounted.rig_from_sensor().translation, expected.translation);
  EXPECT_LT(mounted.rig_from_sensor().rotation.angularDistance(expected.rotation), 1e-12);
  EXPECT_EQ(mounted.camera().width, 64);
  EXPECT_EQ(mounted.camera().height, 32);
  EXPECT_EQ(mounted.duration_s(), 0.03);
  EXPECT_EQ(rig[3].sensor.camera(), builtin_camera("tum_vi_cam0"));
  EXPECT_EQ(rig[3].sensor.rig_from_sensor().translation.x(), 1.0);
  EXPECT_LT(rig[4].sensor.rig_from_sensor().rotation.angularDistance(turned.rotation), 1e-12);
  EXPECT_EQ(rig[4].sensor.rows(), 16U);
  EXPECT_EQ(rig[5].sensor.rig_from_sensor().translation.x(), 2.0);
  // Each sensor has its recorded frames.
  for (const RigSensor& one : rig) EXPECT_EQ(recorded().frames(one.model, one.sensor).size(), 1U);
}

TEST(RigFile, BadOnesAreRefused) {
  const Scratch scratch;
  const auto refused = [&](const Json& rig, const std::vector<std::string>& words) {
    const auto file = scratch.file("rig.json", rig.dump());
    expect_input_error([&] { (void)read_rig_file(file, recorded()); }, words);
  };
  const auto one = [](Json keys) {
    Json sensor{{"name", "a"}, {"sensor", "front"}};
    sensor.update(keys);
    return rig_of(Json::array({sensor}));
  };
  const Json place{{"position_m", {0, 0, 1}}};
  refused(rig_of(Json::array()), {"rig.json", "sensors", "none"});
  refused({{"format", "rig"}, {"version", 1}, {"sensors", Json::array()}}, {"format", "simuli rig"});
  refused(rig_of({{{"name", "a"}, {"sensor", "front"}}, {{"name", "a"}, {"sensor", "top"}}}),
          {"sensors[1].name", "twice"});
  refused(one({{"sensor", "hesai_x32"}}), {"sensors[0].sensor", "hesai_xt32"});
  refused(one({{"sensor", "nowhere.json"}}), {"sensors[0].sensor", "nowhere.json"});
  refused(one({{"sensor", 3}}), {"sensors[0].sensor"});
  refused(one({{"name", "a/b"}}), {"sensors[0].name"});
  refused(one({{"mounting", place}}), {"sensors[0].mounting"});
  refused(one({{"mount", {{"position_cm", {0, 0, 1}}}}}), {"sensors[0].mount.position_m"});
  refused(one({{"mount", {{"position_m", {0, 0, 1}}, {"yaw_rad", 1}}}}), {"sensors[0].mount", "yaw_rad"});
  refused(one({{"mount", place}, {"rig_from_sensor", to_json(Pose{})}}), {"sensors[0].mount", "one of"});
  refused(one({{"width_px", 64}}), {"sensors[0].height_px"});
  refused(one({{"sensor", "top"}, {"width_px", 64}, {"height_px", 32}}), {"sensors[0].width_px", "LiDAR"});
  refused(one({{"readout_s", 0.01}}), {"sensors[0].readout_s", "recorded"});
}

}  // namespace rig_file_test
}  // namespace simuli

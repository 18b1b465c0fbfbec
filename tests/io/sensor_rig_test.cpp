#include "io/scene/sensor_rig.hpp"

#include <gtest/gtest.h>

#include "io/log/sensor_json.hpp"
#include "tests/host/expect_error.hpp"
#include "tests/io/scratch.hpp"
#include "tests/support/scenes.hpp"

namespace simuli {
namespace sensor_rig_test {

using test::expect_input_error;
using test::Scratch;

Pose at(double x) { return {Eigen::Quaterniond::Identity(), {x, 0.0, 0.0}}; }

SceneFile some_scene() {
  SceneFile file;
  Camera camera = test::small_camera(8, 6);
  camera.name = "front";
  file.cameras.push_back({camera, at(1.0)});
  Lidar lidar = test::small_lidar(4, 20);
  lidar.name = "top";
  file.lidars.push_back({lidar, at(2.0)});
  return file;
}

void expect_unknown(const SensorRig& rig, const std::string& name, const std::string& said) {
  try {
    (void)rig.find(name);
    ADD_FAILURE() << name;
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kUsage);
    EXPECT_NE(std::string(error.what()).find(said), std::string::npos) << error.what();
  }
}

TEST(SensorRig, FindsItsOwn) {
  const SensorRig rig(some_scene());
  ASSERT_EQ(rig.sensors().size(), 2U);
  EXPECT_TRUE(rig.find("front").is_camera());
  EXPECT_EQ(rig.find("front").rig_from_sensor().translation.x(), 1.0);
  EXPECT_EQ(rig.find("top", at(9.0)).rig_from_sensor().translation.x(), 2.0);
}

TEST(SensorRig, MountsOthersInTheirPlace) {
  const SensorRig rig(some_scene());
  const Sensor lidar = rig.find("hesai_xt32@20");
  EXPECT_EQ(lidar.name(), "hesai_xt32@20");
  EXPECT_EQ(lidar.duration_s(), 0.05);
  EXPECT_EQ(lidar.rig_from_sensor().translation.x(), 2.0);
  EXPECT_EQ(rig.find("tum_vi_cam0").rig_from_sensor().translation.x(), 1.0);
  EXPECT_EQ(rig.find("tum_vi_cam0", at(9.0)).rig_from_sensor().translation.x(), 1.0);
  EXPECT_EQ(SensorRig().find("tum_vi_cam0", at(9.0)).rig_from_sensor().translation.x(), 9.0);
  const Scratch scratch;
  const BuiltinLidar built_in = builtin_lidar_with_facts("velodyne_vlp16@20");
  const auto file = scratch.file("mine.json", to_json({built_in.model, built_in.facts}).dump());
  EXPECT_EQ(rig.find(file.string()).name(), "mine");
  EXPECT_EQ(named_sensor(file.string()).duration_s(), 0.05);
  write_sensor_file(scratch / "wide.json", CameraFile{builtin_camera("tum_vi_cam0")});
  const Sensor wide = rig.find((scratch / "wide.json").string());
  EXPECT_EQ(wide.name(), "wide");
  EXPECT_EQ(wide.camera(), builtin_camera("tum_vi_cam0"));
  EXPECT_EQ(wide.rig_from_sensor().translation.x(), 1.0);
  const SensorRig empty{SceneFile{}};
  expect_input_error([&] { (void)empty.find("hesai_xt32"); }, {"lidars", "none"});
  expect_input_error([&] { (void)empty.find("tum_vi_cam0"); }, {"cameras", "none"});
  expect_input_error([&] { (void)rig.find((scratch / "nowhere.json").string()); }, {"nowhere.json"});
}

TEST(SensorRig, NamesTheNearest) {
  const SensorRig rig(some_scene());
  expect_unknown(rig, "hesai_x32", "did you mean hesai_xt32");
  expect_unknown(rig, "hesai_x32", "? allowed front, top, those that \"simuli info sensors\" lists");
  expect_unknown(rig, "frnt", "did you mean front? ");
  expect_unknown(SensorRig(), "hesai_x32", "did you mean hesai_xt32");
  expect_unknown(SensorRig(), "nope", "found \"nope\", allowed those that");
  expect_unknown(SensorRig(), "tum_vi_cam9", "tum_vi_cam0");
  expect_unknown(rig, "qqqqqqqqqqqqqqqqqqqqqqqq", "\", allowed front, top, those");
  expect_unknown(rig, "hesai_xt32@7", "turns per second");
}

TEST(SensorRig, OpensNoFileForOthers) {
  SensorRig rig(some_scene());
  rig.refuse_files();
  const Scratch scratch;
  const auto file = scratch.file("mine.json", "{}");
  expect_unknown(rig, file.string(), "allowed front, top");
}

TEST(SensorRig, TakesOneMore) {
  SensorRig rig(some_scene());
  rig.add(named_sensor("velodyne_vlp16").mounted(at(5.0)));
  EXPECT_EQ(rig.find("velodyne_vlp16").rig_from_sensor().translation.x(), 5.0);
  EXPECT_THROW(rig.add(named_sensor("velodyne_vlp16")), Error);
  for (const std::string& name : {std::string("../x"),
                                  std::string("a/b"),
                                  std::string(".."),
                                  std::string("a\n"),
                                  std::string("\xE2\x80\xAE"),
                                  std::string(),
                                  std::string(129, 'a')}) {
    expect_error(ErrorKind::kInput, "name", [&] { rig.add(named_sensor("velodyne_vlp16").named(name)); });
  }
}

TEST(SensorRig, CamerasOfASceneTakeWhatTheyTook) {
  SceneFile file = some_scene();
  EXPECT_EQ(SensorRig(file).find("front").duration_s(), 0.0);  // unknown
  file.recorded_frames["front"] = {{0.0, 0.02}, {1.0, 1.03}, {2.0, 2.02}};
  EXPECT_NEAR(SensorRig(file).find("front").duration_s(), 0.02, 1e-12);
}

TEST(SensorRig, FramesAreThoseOfThePlace) {
  SceneFile file = some_scene();
  Lidar rear = std::get<Lidar>(file.lidars.front().model);
  rear.name = "rear";
  file.lidars.push_back({rear, at(3.0)});
  file.recorded_frames = {{"top", {{1.0, 1.1}, {1.1, 1.2}}}, {"rear", {{5.0, 5.1}}}};
  const SensorRig rig(file);
  const auto frames = [&](const std::string& name) { return rig.frames(name, rig.find(name)); };
  ASSERT_EQ(frames("top").size(), 2U);
  EXPECT_EQ(frames("top").at(1).time_end_s, 1.2);
  EXPECT_EQ(frames("rear").at(0).time_start_s, 5.0);
  // Another sensor uses its own duration.
  ASSERT_EQ(frames("hesai_xt32@20").size(), 2U);
  EXPECT_EQ(frames("hesai_xt32@20").at(1).time_start_s, 1.1);
  EXPECT_EQ(frames("hesai_xt32@20").at(1).time_end_s, 1.1 + 0.05);
  // A file whose name equals a sensor of the rig is mounted like the first sensor of its kind.
  const Scratch scratch;
  write_sensor_file(scratch / "rear.json", LidarFile{builtin_lidar("hesai_xt32")});
  EXPECT_EQ(frames((scratch / "rear.json").string()).size(), 2U);
  EXPECT_TRUE(frames("front").empty());
  EXPECT_TRUE(frames("tum_vi_cam0").empty());
}

TEST(SensorRig, CamerasOfALogTakeWhatTheyTook) {
  Log log;
  log.cameras = some_scene().cameras;
  log.lidars = some_scene().lidars;
  for (const double end_s : {0.02, 0.03, 0.02}) log.images.push_back({"front", "", 0.0, end_s});
  EXPECT_EQ(SensorRig(log).find("front").duration_s(), 0.02);
}

}  // namespace sensor_rig_test
}  // namespace simuli

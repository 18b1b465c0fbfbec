// frames.json beside rendered frames.
#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <string>
#include <variant>

#include "io/base/file.hpp"
#include "io/log/log.hpp"
#include "io/log/sensor_file.hpp"
#include "tests/cli/cli_fixture.hpp"

namespace simuli {
namespace {

using namespace simuli::test;

namespace fs = std::filesystem;

Pose pose_of(const nlohmann::json& json) {
  const auto& p = json.at("position_m");
  const auto& q = json.at("rotation_wxyz");
  return {Eigen::Quaterniond(q.at(0), q.at(1), q.at(2), q.at(3)), Eigen::Vector3d(p.at(0), p.at(1), p.at(2))};
}

void expect_pose(const nlohmann::json& json, const Pose& expected) {
  const Pose found = pose_of(json);
  EXPECT_LT((found.translation - expected.translation).norm(), 1e-9);
  EXPECT_LT(found.rotation.angularDistance(expected.rotation), 1e-9);
}

class FramesCli : public Cli {
 protected:
  nlohmann::json frames_of(const std::string& folder) const {
    return nlohmann::json::parse(read_file(folder_ / folder / "frames.json"));
  }
};

TEST_F(FramesCli, TellWhatWasRenderedAndFromWhere) {
  ASSERT_EQ(
      run("synth street -o s.log --frames 6 --image-width 64 --image-height 36 --lidar-columns 90").exit_code,
      0);
  ASSERT_EQ(run("train s.log -o s.scene --iterations 1 --set init.voxel_m=0.3").exit_code, 0);
  const Outcome cameras = run(
      "render s.scene --sensor front --trajectory s.log --frames 2:3 --scale 0.5 --remove car -o pictures");
  ASSERT_EQ(cameras.exit_code, 0) << cameras.err;
  const nlohmann::json front = frames_of("pictures");
  const Log log = read_log(folder_ / "s.log");
  const LogCamera& camera = log.camera("front");
  ASSERT_EQ(front.at("frames").size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const nlohmann::json& frame = front.at("frames").at(i);
    const ImageFrame& recorded = log.images.at(2 + i);
    EXPECT_EQ(frame.at("files"), nlohmann::json({fs::path(recorded.file).filename().string()}));
    EXPECT_TRUE(fs::exists(folder_ / "pictures" / frame.at("files").at(0)));
    EXPECT_EQ(frame.at("time_start_s"), recorded.time_start_s);
    EXPECT_EQ(frame.at("time_end_s"), recorded.time_end_s);
    expect_pose(frame.at("world_from_sensor_start"),
                log.world_from_rig.at(recorded.time_start_s) * camera.rig_from_camera);
  }
  EXPECT_EQ(front.at("edits"), nlohmann::json({"--remove car"}));
  EXPECT_EQ(front.at("quality"), "balanced");
  EXPECT_EQ(front.at("scene"), "street");
  EXPECT_EQ(front.at("sensor").at("width_px"), 32);  // as rendered
  EXPECT_EQ(front.at("sensor").at("fx_px"), 0.5 * camera.model.fx);
  // What it says of the sensor is a sensor file.
  write_file_atomically(folder_ / "mine.json", front.at("sensor").dump());
  EXPECT_EQ(std::get<CameraFile>(read_sensor_file(folder_ / "mine.json")).model.width, 32);

  const Outcome sweeps =
      run("render s.scene --sensor top --times 0:0.1:0.1 --lane-shift 1 --quality draft --set "
          "render.window=8 -o sweeps");
  ASSERT_EQ(sweeps.exit_code, 0) << sweeps.err;
  const nlohmann::json top = frames_of("sweeps");
  EXPECT_EQ(top.at("frames").at(1).at("files"), nlohmann::json({"top_000001.ply", "top_000001_range.png"}));
  EXPECT_EQ(top.at("edits"), nlohmann::json({"--lane-shift 1"}));
  const Pose rig_from_shifted{Eigen::Quaterniond::Identity(), {0.0, 1.0, 0.0}};
  const Pose mounting = rig_from_shifted * log.lidar("top").rig_from_lidar;
  expect_pose(top.at("rig_from_sensor"), mounting);
  const nlohmann::json& turn = top.at("frames").at(0);
  EXPECT_GT(turn.at("time_end_s"), turn.at("time_start_s"));
  expect_pose(turn.at("world_from_sensor_end"), log.world_from_rig.at(turn.at("time_end_s")) * mounting);
  EXPECT_EQ(top.at("quality"), "draft");
  const auto& settings = top.at("settings");
  EXPECT_NE(std::find(settings.begin(), settings.end(), "render.window=8"), settings.end());
}

}  // namespace
}  // namespace simuli

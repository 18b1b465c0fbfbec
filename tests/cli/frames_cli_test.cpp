// frames.json beside rendered frames.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <variant>
#include <vector>

#include "io/base/file.hpp"
#include "io/log/log.hpp"
#include "io/log/sensor_file.hpp"
#include "io/picture/image.hpp"
#include "io/splat/ply.hpp"
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

TEST_F(FramesCli, MasksComeIntoACopyOfTheLog) {
  ASSERT_EQ(
      run("synth street -o s.log --frames 2 --image-width 64 --image-height 36 --lidar-columns 90").exit_code,
      0);
  Image hood(32, 18, 1);
  std::fill(hood.data.begin() + 12 * 32, hood.data.end(), 1.0F);
  write_image(folder_ / "hood.png", hood);
  const std::string before = read_file(folder_ / "s.log" / "log.json");
  const Outcome done = run("mask s.log front:hood.png -o masked.log");
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_NE(done.out.find("front: 33.3 % of its pictures hidden"), std::string::npos) << done.out;
  EXPECT_EQ(read_file(folder_ / "s.log" / "log.json"), before);
  EXPECT_NE(run("info masked.log").out.find("33.3 % hidden by masks"), std::string::npos);
  EXPECT_EQ(run("info s.log").out.find("hidden by masks"), std::string::npos);
  const auto info = nlohmann::json::parse(run("info masked.log --json").out);
  EXPECT_NEAR(info.at("hidden_shares").at("front").get<double>(), 1.0 / 3.0, 1e-9);
  expect_failure("mask masked.log front:hood.png -o more.log", kInput, "masks/front/hood.png, already");
  expect_failure("mask s.log front:hood.png -o masked.log", kInput, "masked.log");
  expect_failure("mask s.log rear:hood.png -o more.log", kInput, "rear");
  expect_failure("mask s.log hood.png -o more.log", kUsage, "CAMERA:FILE");
  expect_failure("mask s.log front:none.png -o more.log", kInput, "none.png");
  EXPECT_FALSE(fs::exists(folder_ / "more.log"));
}

TEST_F(FramesCli, TellWhatWasRenderedAndFromWhere) {
  make_street_scene();
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
  EXPECT_EQ(top.at("clouds"), nlohmann::json({{"frame", "world"}, {"coordinates", "float32"}}));
  EXPECT_FALSE(front.contains("clouds"));

  // In the sensor's own axes: the start's pose brings the points to where they are in the world.
  const Outcome own =
      run("render s.scene --sensor top --times 0:0:1 --lane-shift 1 --quality draft --set render.window=8 "
          "--cloud-frame sensor_start -o own");
  ASSERT_EQ(own.exit_code, 0) << own.err;
  EXPECT_EQ(frames_of("own").at("clouds").at("frame"), "sensor_start");
  const auto in_world = read_points_ply(folder_ / "sweeps/top_000000.ply");
  const auto in_sensor = read_points_ply(folder_ / "own/top_000000.ply");
  ASSERT_EQ(in_world.size(), in_sensor.size());
  ASSERT_GT(in_world.size(), 100U);
  const Pose world_from_sensor = pose_of(turn.at("world_from_sensor_start"));
  EXPECT_GT((in_world[0] - in_sensor[0]).norm(), 0.5);
  for (std::size_t i = 0; i < in_world.size(); ++i) {
    ASSERT_LT((world_from_sensor * in_sensor[i] - in_world[i]).norm(), 1e-4);
  }
  expect_failure("render s.scene --sensor top --cloud-frame lidar -o x", kUsage, "sensor_start");
  for (const char* option : {"--clouds npz", "--cloud-frame world"})
    expect_failure(fmt::format("render s.scene --sensor front --frames 1:1 -o x {}", option),
                   kUsage,
                   "found with cameras alone, allowed with a LiDAR");
}

TEST_F(FramesCli, CloudsKeepMillimetresFarFromTheOrigin) {
  ASSERT_EQ(
      run("synth street -o s.log --frames 3 --image-width 64 --image-height 36 --lidar-columns 90").exit_code,
      0);
  Log log = read_log(folder_ / "s.log");
  std::vector<TimedPose> poses = log.world_from_rig.poses();
  for (TimedPose& pose : poses) pose.pose.translation += Eigen::Vector3d(4194304.0, 524288.0, 0.0);
  copy_log(on_path(log, Trajectory(poses)), folder_ / "far.log");
  ASSERT_EQ(run("train far.log -o far.scene --iterations 1 --set init.voxel_m=0.3").exit_code, 0);
  const Outcome sweeps = run("render far.scene --sensor top --times 0:0:1 -o sweeps");
  ASSERT_EQ(sweeps.exit_code, 0) << sweeps.err;
  EXPECT_EQ(sweeps.err.find("warning"), std::string::npos) << sweeps.err;
  EXPECT_EQ(frames_of("sweeps").at("clouds").at("coordinates"), "float64");
  const std::string bytes = read_file(folder_ / "sweeps/top_000000.ply");
  EXPECT_NE(bytes.find("property double x\n"), std::string::npos);
  double x = 0.0;  // of the first point
  std::memcpy(&x, bytes.data() + bytes.find("end_header\n") + 11, sizeof(x));
  EXPECT_NEAR(x, 4194304.0, 200.0);
  EXPECT_NE(x, static_cast<double>(static_cast<float>(x)));
}

TEST_F(FramesCli, CamerasTellDepthActorsAndNormals) {
  make_street_scene();
  const std::string outputs = "rgb,depth,mean_depth,distance,mean_distance,opacity,actors,normals";
  const std::string what = "render s.scene --sensor front --times 0.2:0.2:1 --outputs ";
  const Outcome exr = run(what + outputs + " -o exr");
  ASSERT_EQ(exr.exit_code, 0) << exr.err;
  const nlohmann::json frames = frames_of("exr");
  EXPECT_EQ(frames.at("actors"),
            nlohmann::json::array({{{"id", 1}, {"name", "car"}, {"kind", "car"}, {"class", 1}}}));
  const nlohmann::json info = nlohmann::json::parse(run("--json info s.scene").out);
  ASSERT_EQ(info.at("occluders").size(), 1U);  // what nobody saw behind it is filled
  EXPECT_EQ(info.at("occluders").at(0).at("actor"), "car");
  EXPECT_GT(info.at("occluders").at(0).at("instead"), 0);
  EXPECT_NE(run("info s.scene").out.find("\n  occluder car: "), std::string::npos);
  EXPECT_EQ(frames.at("outputs").size(), 8U);
  const nlohmann::json& files = frames.at("frames").at(0).at("files");
  ASSERT_EQ(files.size(), 8U);
  EXPECT_EQ(files.at(0), "front_000000.png");
  EXPECT_EQ(files.at(1), "front_000000_depth.exr");
  EXPECT_EQ(files.at(6), "front_000000_actors.png");
  const auto image = [&](const char* name) { return read_image(folder_ / "exr" / name); };
  const Image depth = image("front_000000_depth.exr"), distance = image("front_000000_distance.exr");
  const Image normals = image("front_000000_normals.exr");
  ASSERT_EQ(depth.width, 64);
  std::size_t nearer = 0, with_normal = 0;
  for (std::size_t i = 0; i < depth.data.size(); i += 3) {
    EXPECT_LE(depth.data[i], distance.data[i]);
    nearer += depth.data[i] > 1.0F && depth.data[i] < distance.data[i] ? 1 : 0;
    const float length = Eigen::Map<const Eigen::Vector3f>(&normals.data[i]).norm();
    EXPECT_TRUE(length == 0.0F || std::abs(length - 1.0F) < 1e-5F);
    with_normal += length > 0.5F ? 1 : 0;
  }
  EXPECT_GT(nearer, 300U);
  EXPECT_GT(with_normal, 300U);
  // 16 bits: the reader gives shares of 65535.
  const Image actors = image("front_000000_actors.png");
  std::size_t own = 0;
  for (const float value : actors.data) {
    EXPECT_TRUE(value == 0.0F || std::abs(value - 1.0F / 65535.0F) < 1e-9F) << value;
    own += value > 0.0F ? 1 : 0;
  }
  EXPECT_GT(own, 3U);

  const Outcome npz = run(what + "depth,actors,normals --values npz -o npz");
  ASSERT_EQ(npz.exit_code, 0) << npz.err;
  EXPECT_EQ(frames_of("npz").at("frames").at(0).at("files"), nlohmann::json({"front_000000.npz"}));
  const std::string bytes = read_file(folder_ / "npz/front_000000.npz");
  for (const char* part :
       {"depth.npy", "'<f4'", "'shape': (36, 64), ", "actors.npy", "'<u2'", "(36, 64, 3)"}) {
    EXPECT_NE(bytes.find(part), std::string::npos) << part;
  }
  const Outcome sweep = run("render s.scene --sensor top --times 0.1:0.1:1 --outputs actors -o sweep");
  ASSERT_EQ(sweep.exit_code, 0) << sweep.err;
  EXPECT_NE(read_file(folder_ / "sweep/top_000000.ply").find("property ushort actor\n"), std::string::npos);
  EXPECT_EQ(frames_of("sweep").at("actors").size(), 1U);
  expect_failure("render s.scene --sensor top --outputs depth -o x", kUsage, "allowed actors");
  expect_failure("render s.scene --sensor front --outputs rgb,colour -o x", kUsage, "mean_depth");
  expect_failure("render s.scene --sensor front --outputs depth -o x.mp4", kUsage, "with a folder");
  expect_failure(
      "render s.scene --sensor front -o x.avi", kUsage, "found \"x.avi\", allowed a folder, or a file");
}

/// Numbers of a line of words, from the `first` one on.
std::vector<double> numbers_of(const std::string& line, std::size_t first) {
  std::vector<double> out;
  std::istringstream words(line);
  std::string word;
  for (std::size_t i = 0; words >> word; ++i) {
    if (i >= first) out.push_back(std::stod(word));
  }
  return out;
}

TEST_F(FramesCli, LabelsAreThoseOfTheDataSets) {
  make_street_scene();
  const std::string what = "render s.scene --sensor front --sensor top --times 0.1:0.2:0.1 --labels ";
  // frames.json, which the others are made of.
  ASSERT_EQ(run(what + "json -o json").exit_code, 0);
  const nlohmann::json front = frames_of("json/front"), top = frames_of("json/top");
  const nlohmann::json label = front.at("frames").at(0).at("labels").at(0);
  EXPECT_EQ(label.at("actor"), 1);
  const auto pixels = label.at("pixels").get<int>();
  ASSERT_GT(pixels, 3);
  const auto seen = label.at("visible_px").get<std::vector<double>>();
  const auto projected = label.at("projected_px").get<std::vector<double>>();
  EXPECT_LE(pixels, (seen[2] - seen[0]) * (seen[3] - seen[1]));
  EXPECT_GE(label.at("occlusion").get<double>(), 0.0);
  EXPECT_LE(label.at("truncation").get<double>(), 1.0);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(seen[i], projected[i], 2.0) << i;  // of 64 x 36 px
  EXPECT_TRUE(top.at("frames").at(0).at("labels").at(0).contains("returns"));
  // The same place by both sensors' poses.
  const Pose world_from_actor = pose_of(label.at("world_from_actor"));
  const Pose world_from_camera = pose_of(front.at("frames").at(0).at("world_from_sensor_start"));
  const Pose camera_from_actor = pose_of(label.at("sensor_from_actor"));
  EXPECT_LT((world_from_camera * camera_from_actor.translation - world_from_actor.translation).norm(), 0.5);

  ASSERT_EQ(run(what + "kitti -o kitti").exit_code, 0);
  const std::string line = read_file(folder_ / "kitti/front/kitti/label_2/000000.txt");
  ASSERT_EQ(line.substr(0, 4), "Car ");
  const std::vector<double> kitti = numbers_of(line.substr(0, line.find('\n')), 1);
  ASSERT_EQ(kitti.size(), 14U);
  EXPECT_NEAR(kitti[3], std::max(0.0, projected[0] - 0.5), 1e-3);  // its pixels are at their middles
  const auto size_m = label.at("size_m").get<std::vector<double>>();
  EXPECT_NEAR(kitti[7], size_m[2], 1e-3);  // height, width, length
  EXPECT_NEAR(kitti[9], size_m[0], 1e-3);
  EXPECT_NEAR(kitti[10], camera_from_actor.translation.x(), 1e-3);
  EXPECT_NEAR(kitti[11], camera_from_actor.translation.y() + 0.5 * size_m[2], 1e-3);  // under the middle
  EXPECT_NEAR(kitti[12], camera_from_actor.translation.z(), 1e-3);
  EXPECT_TRUE(fs::exists(folder_ / "kitti/front/kitti/image_2/000001.png"));
  EXPECT_NE(read_file(folder_ / "kitti/front/kitti/calib/000000.txt").find("P2: "), std::string::npos);

  ASSERT_EQ(run(what + "coco --class car:truck -o coco").exit_code, 0);
  const nlohmann::json coco = nlohmann::json::parse(read_file(folder_ / "coco/coco.json"));
  EXPECT_EQ(coco.at("images").size(), 2U);
  EXPECT_EQ(coco.at("categories").at(0).at("name"), "truck");
  EXPECT_EQ(coco.at("annotations").at(0).at("area"), pixels);
  EXPECT_EQ(coco.at("annotations").at(0).at("bbox").at(2).get<double>(), seen[2] - seen[0]);

  ASSERT_EQ(run(what + "nuscenes -o nuscenes").exit_code, 0);
  const auto table = [&](const char* name) {
    return nlohmann::json::parse(read_file(folder_ / "nuscenes/v1.0-simuli" / (std::string(name) + ".json")));
  };
  EXPECT_EQ(table("sample").size(), 2U);
  ASSERT_GE(table("sample_annotation").size(), 1U);
  EXPECT_NEAR(table("sample_annotation").at(0).at("size").at(1).get<double>(), size_m[0], 1e-9);
  for (const nlohmann::json& data : table("sample_data"))
    EXPECT_TRUE(fs::exists(folder_ / "nuscenes" / data.at("filename").get<std::string>())) << data;

  expect_failure("render s.scene --sensor top --labels coco -o x", kUsage, "allowed with a camera");
  expect_failure("render s.scene --sensor front --labels kitti --images exr -o x", kUsage, "--images png");
  expect_failure("render s.scene --sensor front --labels json -o x.mp4", kUsage, "with a folder");
  expect_failure("render s.scene --sensor front --labels voc -o x", kUsage, "voc");
  expect_failure("render s.scene --sensor front --class nobody:car -o x", kUsage, "nobody");
}

TEST_F(FramesCli, FlowLeadsToTheNextFrame) {
  make_street_scene();
  const std::string what = "render s.scene --sensor front --times ";
  ASSERT_EQ(run(what + "0.1:0.2:0.1 --outputs flow,scene_flow --values npz -o npz").exit_code, 0);
  const std::string first = read_file(folder_ / "npz/front_000000.npz");
  EXPECT_NE(first.find("scene_flow.npy"), std::string::npos);
  ASSERT_EQ(run(what + "0.1:0.2:0.1 --outputs flow --values png -o png").exit_code, 0);
  const Image flow = read_image(folder_ / "png/front_000000_flow.png");
  std::size_t valid = 0;
  for (std::size_t i = 0; i < flow.data.size(); i += 3) valid += flow.data[i + 2] > 0.0F ? 1U : 0U;
  EXPECT_GT(valid, 300U);
  EXPECT_FALSE(fs::exists(folder_ / "png/front_000001_flow.png"));  // the last one leads nowhere
  expect_failure(what + "0.1:0.1:0.1 --outputs flow -o x", kUsage, "a frame behind it");
}

TEST_F(FramesCli, AreTheRecordedOnesOfTheSensor) {
  make_street_scene();
  const Log log = read_log(folder_ / "s.log");
  ASSERT_GT(log.world_from_rig.poses().size(), log.images.size());
  const auto render = [&](const std::string& arguments, const std::string& to) {
    const Outcome done = run("render s.scene " + arguments + " -o " + to);
    EXPECT_EQ(done.exit_code, 0) << done.err;
    return frames_of(to).at("frames");
  };
  const nlohmann::json all = render("--sensor front", "all");
  ASSERT_EQ(all.size(), log.images.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all.at(i).at("time_start_s"), log.images.at(i).time_start_s);
    EXPECT_EQ(all.at(i).at("time_end_s"), log.images.at(i).time_end_s);
  }
  const nlohmann::json reported = nlohmann::json::parse(run("info s.scene --json").out).at("recorded_frames");
  EXPECT_EQ(reported.at("top").at("frames"), 6);
  EXPECT_NE(run("info s.scene").out.find("\n    6 frames, 10.0 per second, 0.05 to "), std::string::npos);
  const nlohmann::json some = render("--sensor front --frames 2:3", "some");
  ASSERT_EQ(some.size(), 2U);
  EXPECT_EQ(some.at(0), all.at(2));
  EXPECT_EQ(read_file(folder_ / "some/front_000003.png"), read_file(folder_ / "all/front_000003.png"));
  // Another LiDAR in the place: its turns begin when those of the recorded one did.
  const nlohmann::json turns = render("--sensor hesai_xt32@20", "turns");
  ASSERT_EQ(turns.size(), log.sweeps.size());
  EXPECT_EQ(turns.at(4).at("time_start_s"), log.sweeps.at(4).time_start_s);
  EXPECT_NEAR(turns.at(4).at("time_end_s"), log.sweeps.at(4).time_start_s + 0.05, 1e-12);
  // --duration says it of recorded frames, too.
  const nlohmann::json slow = render("--sensor front --frames 1:1 --duration 0.02", "slow");
  EXPECT_NEAR(slow.at(0).at("time_end_s"), log.images.at(1).time_start_s + 0.02, 1e-12);
  expect_failure("render s.scene --sensor front --frames 2:6 -o x", kUsage, "a:b with 0 <= a <= b < 6");

  // A scene that doesn't know its frames.
  nlohmann::json old = nlohmann::json::parse(read_file(folder_ / "s.scene/scene.json"));
  ASSERT_EQ(old.erase("recorded_frames"), 1U);
  write_file_atomically(folder_ / "s.scene/scene.json", old.dump());
  expect_failure("render s.scene --sensor front -o x", kInput, "allowed at least one, or --times");
  expect_failure("render s.scene --sensor front --frames 0:1 -o x", kInput, "recorded_frames of front");
  EXPECT_EQ(render("--sensor front --trajectory s.log", "by_log"), all);
  EXPECT_EQ(render("--sensor front --times 0.05:0.15:0.1", "by_times").size(), 2U);
}

TEST_F(FramesCli, RollingShuttersTakeWhatTheyTook) {
  make_street();
  nlohmann::json log = nlohmann::json::parse(read_file(folder_ / "s.log/log.json"));
  log.at("cameras").at(0).at("shutter") = "top_to_bottom";
  for (nlohmann::json& image : log.at("images")) {
    image.at("time_end_ns") = image.at("time_start_ns").get<std::int64_t>() + 30'000'000;
  }
  write_file_atomically(folder_ / "s.log/log.json", log.dump());
  ASSERT_EQ(run("train s.log -o s.scene --iterations 1 --set init.voxel_m=0.3").exit_code, 0);
  ASSERT_EQ(run("render s.scene --sensor front --times 0.1:0.1:1 -o known").exit_code, 0);
  const nlohmann::json known = frames_of("known");
  EXPECT_NEAR(known.at("frames").at(0).at("time_end_s"), 0.13, 1e-12);
  EXPECT_NEAR(known.at("sensor").at("readout_s"), 0.03, 1e-12);
  // Another one in its place is not asked what it takes.
  nlohmann::json mine = nlohmann::json::parse(run("info s.scene front --json").out);
  ASSERT_EQ(mine.erase("readout_s"), 1U);
  write_file_atomically(folder_ / "mine.json", mine.dump());
  expect_failure("render s.scene --sensor mine.json --times 0.1:0.1:1 -o x", kUsage, "--duration");
  expect_failure("render s.scene --sensor mine.json -o x", kUsage, "--duration");
}

TEST_F(FramesCli, ARenderedDriveIsALog) {
  make_street_scene();
  const Outcome rendered =
      run("render s.scene --trajectory s.log --duplicate car:twin --move twin:-3,-3,0 --as-log -o new.log "
          "--json");
  ASSERT_EQ(rendered.exit_code, 0) << rendered.err;
  EXPECT_EQ(nlohmann::json::parse(rendered.out).at("sensors").size(), 2U);
  const Log recorded = read_log(folder_ / "s.log"), log = read_log(folder_ / "new.log");
  EXPECT_EQ(log.images.size(), recorded.images.size());
  ASSERT_EQ(log.sweeps.size(), recorded.sweeps.size());
  EXPECT_EQ(log.sweeps[2].time_start_s, recorded.sweeps[2].time_start_s);
  EXPECT_EQ(log.camera("front").model.width, 64);
  ASSERT_EQ(log.actors.size(), 2U);
  EXPECT_EQ(log.actors[1].name, "twin");
  // What the sweep says is what the LiDAR sees: the clouds of the same frames.
  ASSERT_EQ(run("render s.scene --trajectory s.log --duplicate car:twin --move twin:-3,-3,0 --sensor top "
                "--frames 2:2 -o clouds")
                .exit_code,
            0);
  const Sweep sweep = read_sweep(folder_ / "new.log" / log.sweeps[2].file, log.lidar("top").model);
  const auto returns =
      std::count_if(sweep.range.begin(), sweep.range.end(), [](float range) { return range > 0.0F; });
  EXPECT_GT(returns, 100);
  EXPECT_EQ(static_cast<std::size_t>(returns), read_points_ply(folder_ / "clouds/top_000002.ply").size());
  EXPECT_EQ(run("train new.log -o again.scene --iterations 1 --set init.voxel_m=0.3").exit_code, 0);
  EXPECT_EQ(run("eval again.scene new.log").exit_code, 0);

  // Some sensors, one of them another.
  const Outcome some =
      run("render s.scene --sensor top --sensor velodyne_vlp16 --times 0:0.2:0.1 --lane-shift 1 --as-log -o "
          "some.log");
  ASSERT_EQ(some.exit_code, 0) << some.err;
  const Log two = read_log(folder_ / "some.log");
  EXPECT_TRUE(two.cameras.empty());
  ASSERT_EQ(two.lidars.size(), 2U);
  EXPECT_EQ(two.sweeps.size(), 6U);
  const Eigen::Vector3d shift =
      two.lidar("top").rig_from_lidar.translation - recorded.lidar("top").rig_from_lidar.translation;
  EXPECT_LT((shift - Eigen::Vector3d(0.0, 1.0, 0.0)).norm(), 1e-9);
  expect_failure("render s.scene --sensor top --sensor top --as-log -o x", kUsage, "each name once");
  expect_failure("render s.scene --as-log --outputs depth -o x", kUsage, "--outputs");
  expect_failure("render s.scene --as-log -o x.mp4", kUsage, "with a folder");
}

}  // namespace
}  // namespace simuli

#include <fmt/format.h>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "host/apps/cli/base/edits.hpp"
#include "host/apps/cli/base/refuse.hpp"
#include "host/apps/cli/import/run_import.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/split.hpp"
#include "io/import/ros2/ros2_log.hpp"
#include "io/log/sensor_file.hpp"
#include "io/scene/sensor_rig.hpp"

namespace simuli::cli {
namespace {

struct Ros2Command : Ros2Options {
  std::vector<std::string> tables, mountings, readouts, files;
};

Ros2Lidar lidar_of(const std::string& text) {
  const auto [topic, rest] = parted("--lidar", text, '=');
  const std::string name = rest.substr(0, rest.rfind(':'));
  Ros2Lidar lidar{topic, lidar_table(name), name.size() < rest.size() ? rest.substr(name.size() + 1) : ""};
  std::error_code ignored;
  const bool is_file = name.ends_with(".json") || std::filesystem::is_regular_file(name, ignored);
  const LidarFacts facts = is_file ? read_lidar_file(name).facts : builtin_lidar_with_facts(name).facts;
  lidar.is_mode_given = !is_file && name.find('@') != std::string::npos;
  lidar.modes = lidar.is_mode_given ? std::vector{facts.mode} : facts.modes;
  return lidar;
}

std::pair<std::string, Ros2Shutter> shutter_of(const std::string& text) {
  const auto [topic, rest] = parted("--shutter", text, ':');
  const std::vector<std::string> parts = split(rest, ':');
  char* end = nullptr;
  const double readout_s = parts.size() == 2 ? std::strtod(parts[1].c_str(), &end) : 0.0;
  if (parts.size() != 2 || end == parts[1].c_str() || *end != '\0' ||
      !(readout_s > 0.0 && readout_s <= 1.0)) {
    refuse("--shutter", text, "TOPIC:KIND:SECONDS, at most 1 s");
  }
  try {
    return {topic, {shutter_from_string(parts[0], "--shutter", topic), readout_s}};
  } catch (const Error& error) {
    throw Error(ErrorKind::kUsage, error.what());
  }
}

Log import_recording(Ros2Command given,
                     const FrameProgress& progress,
                     Ros2Report& report) {
  for (const std::string& text : given.tables) given.lidars.push_back(lidar_of(text));
  for (const std::string& text : given.mountings) {
    const auto [topic, mount] = parted("--mount", text, ':');
    given.mounts[topic] = parse_mounting("--mount", mount);
  }
  for (const std::string& text : given.files) {
    const auto [topic, file] = parted("--camera", text, '=');
    given.lenses[topic] = read_camera_file(file);
  }
  for (const std::string& text : given.readouts) given.shutters.insert(shutter_of(text));
  return import_ros2(given, progress, report);
}

std::vector<std::string> print_ros2(const Ros2Report& r) {
  std::vector<std::string> lines = r.notes;
  if (r.unposed > 0)
    lines.push_back(fmt::format("left out: {} clouds and pictures outside the trajectory's time", r.unposed));
  if (r.twice > 0) lines.push_back(fmt::format("left out: {} clouds and pictures recorded twice", r.twice));
  if (r.sweeps > 0) lines.push_back(points_line(r.points));
  return lines;
}

}  // namespace

std::pair<std::string, std::string> parted(const char* option,
                                           const std::string& text,
                                           char at,
                                           const char* first) {
  const std::size_t place = text.find(at);
  if (place == 0 || place == std::string::npos || place + 1 == text.size()) {
    refuse(option, text, fmt::format("{}{}...", first, at));
  }
  return {text.substr(0, place), text.substr(place + 1)};
}

Lidar lidar_table(const std::string& name) {
  const Sensor sensor = named_sensor(name);
  const auto* table = sensor.is_camera() ? nullptr : std::get_if<Lidar>(&sensor.lidar());
  if (table == nullptr) {
    refuse("--lidar", name, "a LiDAR with beams (simuli info sensors)");
  }
  return *table;
}

void add_import_ros2(Command import, const Globals& globals) {
  const auto command = std::make_shared<Ros2Command>();
  Ros2Command& options = *command;
  Command sub = import.command("mcap", "a recording of ROS 2: clouds, pictures, transforms");
  sub.option("FILE", options.recording, ".mcap or .db3 file, or a folder of them").required();
  sub.option("--lidar",
             command->tables,
             "TOPIC=SENSOR[:FRAME], a topic of PointCloud2 and its beams: built-in (velodyne_vlp16, at "
             "20 Hz "
             "only velodyne_vlp16@20) or a LiDAR file (simuli fit beams); FRAME: frame of the beams, "
             "if it is "
             "not the frame of the clouds")
      .one_at_a_time();
  sub.flag("--no-lidars", options.without_lidars, "import only pictures").excludes("--lidar");
  sub.option(
         "--cameras",
         command->cameras,
         "comma-separated topics of Image or CompressedImage; default: all with a camera_info")
      .comma_separated()
      .shown_as("TOPIC,...", "");
  sub.option("--camera",
             command->files,
             "TOPIC=FILE, a camera file (simuli info NAME --json, simuli fit lens) for a missing or wrong "
             "CameraInfo")
      .one_at_a_time();
  sub.option("--topics",
             command->topics,
             "comma-separated topics to read, including transforms and camera_infos; default: all")
      .comma_separated()
      .shown_as("TOPIC,...", "");
  sub.option("--ignore", command->ignore, "comma-separated topics to skip")
      .comma_separated()
      .shown_as("TOPIC,...", "")
      .excludes("--topics");
  sub.option("--rig-frame", options.rig_frame, "the vehicle's frame").with_default();
  sub.option(
      "--world-frame", options.world_frame, "frame of the trajectory; default: the root frame of the rig");
  sub.option("--odometry", options.odometry, "topic of Odometry for the trajectory, instead of transforms");
  sub.flag("--no-poses", options.without_poses, "store no ego poses; simuli align estimates the trajectory");
  sub.option("--mount",
             command->mountings,
             "TOPIC:X,Y,Z,ROLL,PITCH,YAW of a sensor on the rig, m and degrees, instead of transforms")
      .one_at_a_time();
  sub.option("--shutter",
             command->readouts,
             "TOPIC:KIND:SECONDS, readout of a camera's rows that starts at the stamp: top_to_bottom ...")
      .one_at_a_time();
  sub.option("--stamp",
             options.stamp,
             "time of a cloud's stamp in its sweep, start or end; default: from the points' times")
      .one_of({"start", "end"});
  sub.option("--point-time",
             options.point_time,
             "FIELD:UNIT[:absolute], UNIT s, ms, us, ns; default: the drivers' names");
  sub.option(
      "--intensity", options.intensity, "FIELD:MOST; default: intensity:255, for Ouster reflectivity:255");
  add_run<Ros2Report>(sub, "mcap", command, globals, import_recording, print_ros2);
}

}  // namespace simuli::cli

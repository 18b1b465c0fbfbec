#include "host/apps/cli/info/info.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fstream>
#include <iostream>
#include <memory>
#include <system_error>
#include <vector>

#include "host/apps/cli/base/commands.hpp"
#include "host/core/base/close_names.hpp"
#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/scene/sensor_rig.hpp"
#include "io/scene/splat_scene.hpp"

namespace simuli::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kAllSensors = "sensors";

struct InfoOptions {
  std::string target;
  std::string sensor;  // sensor of the target; empty: the target itself
};

/// Returns false also for a name that is too long. Throws Error{kInput} for a folder without search
/// permission.
bool is_there(const fs::path& path) {
  std::error_code failed;
  const bool found = fs::exists(path, failed);
  if (failed == std::errc::permission_denied)
    throw_input_error(
        path.parent_path().string(), "folder", failed.message(), "a folder with search permission");
  return found;
}

void print_any(const SensorFile& file, bool json) {
  std::visit([json](const auto& sensor) { print_sensor(sensor, json); }, file);
}

/// Throws Error{kInput} unless the file starts like JSON, the format of sensor files.
void need_json(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  char first = '{';
  if (in >> first; first == '{') return;
  throw_input_error(file.string(),
                    "file",
                    "other data",
                    "JSON of a sensor; splats (.ply, .spz, .glb); the folder of a log or a scene");
}

/// Prints the sensor `name` of a log or a scene.
void print_sensor_of(const std::string& folder, const SensorRig& rig, const std::string& name, bool json) {
  if (rig.has(name)) return print_any(sensor_file_of(rig.find(name)), json);
  std::vector<std::string> known;
  for (const Sensor& sensor : rig.sensors()) known.push_back(sensor.name());
  throw_input_error(folder, "sensor", '"' + name + '"', fmt::format("{}", fmt::join(known, ", ")));
}

bool holds(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Prints the built-in sensor `name`, or the list of all for "sensors".
void print_builtin(const std::string& name, bool json) {
  const std::vector<std::string> cameras = builtin_camera_names();
  const std::vector<std::string> lidars = builtin_lidar_names();
  if (name == kAllSensors) return print_sensor_names(cameras, lidars, json);
  if (holds(lidars, name.substr(0, name.find('@')))) {
    const BuiltinLidar sensor = builtin_lidar_with_facts(name);
    return print_sensor(LidarFile{sensor.model, sensor.facts}, json);
  }
  if (holds(cameras, name)) {
    return print_sensor(CameraFile{builtin_camera(name), 0.0, builtin_camera_source(name)}, json);
  }
  std::vector<std::string> known = cameras;
  known.insert(known.end(), lidars.begin(), lidars.end());
  known.emplace_back(kAllSensors);
  const std::vector<std::string> close = close_names(name, known);
  throw_input_error(
      name,
      "folder",
      is_there(name) ? "neither log.json nor scene.json" : "nothing of that name",
      close.empty()
          ? fmt::format("a log, a scene, a splat or sensor file, or a sensor of \"{}\"", kAllSensors)
          : fmt::format("a log, a scene, a splat or sensor file, or a sensor like {}",
                        fmt::join(close, ", ")));
}

void info(const InfoOptions& options, bool json) {
  const fs::path target = options.target;
  if (is_there(target / "log.json")) {
    const Log log = read_log(target);
    if (options.sensor.empty()) return print_log(log, json);
    return print_sensor_of(options.target, SensorRig(log), options.sensor, json);
  }
  if (is_there(target / "scene.json")) {
    const SceneFile scene = read_scene(target);
    if (options.sensor.empty()) return print_scene(scene, json);
    return print_sensor_of(options.target, SensorRig(scene), options.sensor, json);
  }
  if (!options.sensor.empty()) {
    throw Error(
        ErrorKind::kUsage,
        fmt::format(
            "{} is a sensor: found \"{}\" behind it, allowed nothing", options.target, options.sensor));
  }
  std::error_code ignored;
  if ((is_splat_file(target) || has_other_splat_extension(target)) && is_there(target))
    return print_splats(target, json);
  if (ending_of(target) == ".mcap" && is_there(target)) {
    throw_input_error(options.target,
                      "file",
                      "a recording",
                      "a log made by simuli import mcap, whose option --survey prints the contents");
  }
  if (fs::is_regular_file(target, ignored)) {
    need_json(target);
    return print_any(read_sensor_file(target), json);
  }
  print_builtin(options.target, json);
}

}  // namespace

void add_info(Command app, const Globals& globals) {
  const auto options = std::make_shared<InfoOptions>();
  Command command = app.command("info", "print the contents of a log, a scene, splats or a sensor");
  command
      .option(
          "TARGET",
          options->target,
          "log folder, scene folder, splats (.ply, .spz, .glb), sensor file, built-in sensor (a LiDAR's name "
          "may end in "
          "@COLUMNSxHZ), or \"sensors\" for the list of them")
      .required()
      .completed_by([] {
        std::vector<std::string> names = builtin_sensor_names();
        names.emplace_back(kAllSensors);
        return names;
      });
  command.option("SENSOR", options->sensor, "name of a sensor of the log or scene");
  command.run([options, &globals] { info(*options, globals.json); });
}

}  // namespace simuli::cli

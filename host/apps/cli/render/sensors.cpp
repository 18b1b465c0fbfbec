#include "host/apps/cli/render/sensors.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <set>
#include <utility>

#include "host/apps/cli/base/edits.hpp"
#include "host/apps/cli/base/numbers.hpp"
#include "host/apps/cli/base/refuse.hpp"
#include "host/core/base/image.hpp"
#include "optim/base/frames.hpp"

namespace simuli::cli {
namespace {

Pose rig_from_sensor(const std::string& mount, bool is_camera) {
  const Mounting mounting = parse_mounting("--mount", mount);
  return is_camera ? mounting.rig_from_camera() : mounting.rig_from_lidar();
}

std::pair<int, int> parse_size(const std::string& size) {
  const std::vector<double> sides = parse_numbers("--size", size, 2, 'x');
  for (const double side : sides) {
    const bool allowed = side >= 1.0 && side <= kLargestSide_px && side == std::floor(side);
    if (!allowed)
      refuse("--size", size, fmt::format("WIDTHxHEIGHT, whole pixels from 1 to {}", kLargestSide_px));
  }
  return {static_cast<int>(sides[0]), static_cast<int>(sides[1])};
}

Sensor sized(const Sensor& sensor, const SensorOptions& options) {
  if (!sensor.is_camera()) return sensor;
  if (!options.size.empty()) {
    const auto [width, height] = parse_size(options.size);
    return sensor.resized(width, height);
  }
  const Camera scaled = scaled_camera(sensor.camera(), options.scale);
  return sensor.resized(scaled.width, scaled.height);
}

std::vector<RigSensor> named_sensors(const SensorRig& recorded, const SensorOptions& options) {
  if (options.names.empty() && recorded.sensors().empty()) {
    refuse("--sensor", "", "at least one, or --rig FILE: the scene has none of its own");
  }
  const bool is_mounted = !options.mount.empty();
  if (is_mounted && options.names.size() != 1) {
    refuse("--mount", options.mount, "with one --sensor; a --rig FILE mounts many");
  }
  std::vector<RigSensor> sensors;
  if (options.names.empty()) {
    for (const Sensor& own : recorded.sensors()) sensors.push_back({own, own.name()});
    return sensors;
  }
  std::set<std::string> known;
  for (const std::string& name : options.names) {
    RigSensor found{is_mounted ? recorded.find(name, Pose{}) : recorded.find(name), name};
    if (is_mounted) {
      found.sensor = found.sensor.mounted(rig_from_sensor(options.mount, found.sensor.is_camera()));
    }
    if (!known.insert(found.sensor.name()).second) refuse("--sensor", name, "each name once");
    sensors.push_back(std::move(found));
  }
  return sensors;
}

}  // namespace

void add_sensor_options(Command sub, SensorOptions& options) {
  sub.option("--sensor",
             options.names,
             "a sensor of the scene, or a built-in one or a sensor file in its place; may be repeated; "
             "default: all sensors of the scene")
      .one_at_a_time()
      .completed_by(builtin_sensor_names);
  sub.option("--rig", options.rig, "file of sensors and their mountings, all of which are rendered")
      .excludes("--sensor");
  sub.option("--mount",
             options.mount,
             "X,Y,Z,ROLL,PITCH,YAW on the rig, m and degrees; x forward, y left, z up, pitch down, yaw left")
      .excludes("--rig");
  sub.option("--size", options.size, "WIDTHxHEIGHT of the pictures, px");
  sub.option("--scale", options.scale, "size of the pictures relative to the camera's").excludes("--size");
  sub.option("--lane-shift", options.lane_shift_m, "shift of the rig to its left, m");
}

std::vector<RigSensor> find_sensors(const SceneFile& file, const SensorOptions& options, double duration_s) {
  const SensorRig recorded(file);
  std::vector<RigSensor> sensors =
      options.rig.empty() ? named_sensors(recorded, options) : read_rig_file(options.rig, recorded);
  const auto is_camera = [](const RigSensor& requested) { return requested.sensor.is_camera(); };
  if (!options.size.empty() && std::none_of(sensors.begin(), sensors.end(), is_camera)) {
    refuse("--size", options.size, "with cameras");
  }
  const Pose rig_from_shifted{Eigen::Quaterniond::Identity(), {0.0, options.lane_shift_m, 0.0}};
  for (RigSensor& requested : sensors) {
    Sensor& sensor = requested.sensor;
    sensor = sized(sensor, options).mounted(rig_from_shifted * sensor.rig_from_sensor());
    const bool is_reported = duration_s > 0.0 || (duration_s == 0.0 && sensor.is_camera());
    if (is_reported) sensor = sensor.with_duration(duration_s);
  }
  return sensors;
}

}  // namespace simuli::cli

#include "io/scene/rig_file.hpp"

#include <optional>
#include <set>

#include "host/core/base/error.hpp"
#include "host/core/base/image.hpp"
#include "host/core/base/names.hpp"
#include "host/core/scene/mounting.hpp"
#include "io/base/file.hpp"
#include "io/base/json_reader.hpp"
#include "io/log/log_json.hpp"
#include "io/log/sensor_json.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

constexpr char kFormat[] = "simuli rig";

Mounting mounting_from_json(JsonObject& object) {
  const auto angle = [&](const char* key) {
    return object.has(key) ? object.number(key, -360.0, 360.0) : 0.0;
  };
  return {object.vector<3>("position_m"), angle("roll_deg"), angle("pitch_deg"), angle("yaw_deg")};
}

/// Returns the result of `make`; its errors are reported as errors of the file.
template <class Make>
Sensor sensor_of_field(const JsonObject& object, const char* key, const Make& make) {
  try {
    return make();
  } catch (const Error& error) {
    throw Error(ErrorKind::kInput, object.file() + ": " + object.field(key) + ": " + error.what());
  }
}

std::optional<Pose> read_mount(JsonObject& object, bool is_camera) {
  if (object.has("mount") && object.has("rig_from_sensor")) {
    throw_input_error(object.file(), object.field("mount"), "rig_from_sensor, too", "one of the two");
  }
  if (object.has("rig_from_sensor")) return object.object("rig_from_sensor", pose_from_json);
  if (!object.has("mount")) return {};
  const Mounting mounting = object.object("mount", mounting_from_json);
  return is_camera ? mounting.rig_from_camera() : mounting.rig_from_lidar();
}

/// Returns the sensor of the key "sensor": at its recorded mounting without a mount of its own, else at the
/// origin.
RigSensor read_model(JsonObject& object, const SensorRig& recorded, bool is_mounted) {
  const auto find = [&](const std::string& name) {
    return sensor_of_field(
        object, "sensor", [&] { return is_mounted ? recorded.find(name, Pose{}) : recorded.find(name); });
  };
  if (object.get("sensor").is_object()) {
    const Sensor own = sensor_of(object.object("sensor", sensor_file_from_json));
    if (is_mounted) return {own, {}};
    return {sensor_of_field(object, "sensor", [&] { return recorded.in_place(own); }), {}};
  }
  const std::string name = object.text("sensor");
  if (recorded.has(name) || !name.ends_with(".json")) return {find(name), name};
  const std::string beside = (fs::path(object.file()).parent_path() / name).string();
  return {find(beside), beside};
}

Sensor with_camera_keys(JsonObject& object, const Sensor& sensor) {
  for (const char* key : {"width_px", "height_px", "readout_s"}) {
    if (!sensor.is_camera() && object.has(key)) {
      throw_input_error(object.file(), object.field(key), "a value of a LiDAR", "such a key of cameras");
    }
  }
  Sensor changed = sensor;
  if (object.has("width_px") || object.has("height_px")) {
    const auto width = static_cast<int>(object.integer("width_px", 1, kLargestSide_px));
    const auto height = static_cast<int>(object.integer("height_px", 1, kLargestSide_px));
    changed = sensor_of_field(object, "width_px", [&] { return sensor.resized(width, height); });
  }
  return object.has("readout_s") ? changed.with_duration(object.number("readout_s", 0.0)) : changed;
}

RigSensor sensor_from_json(JsonObject& object, const SensorRig& recorded) {
  const std::string name = object.text("name");
  need_name(name, object.file(), object.field("name"));
  const bool is_mounted = object.has("mount") || object.has("rig_from_sensor");
  RigSensor read = read_model(object, recorded, is_mounted);
  if (object.has("readout_s") && recorded.has(read.model)) {
    throw_input_error(object.file(),
                      object.field("readout_s"),
                      "one of a recorded camera",
                      "no such key, because the recorded frames determine it");
  }
  read.sensor = with_camera_keys(object, read.sensor).named(name);
  if (const auto mount = read_mount(object, read.sensor.is_camera())) {
    read.sensor = read.sensor.mounted(*mount);
  }
  return read;
}

}  // namespace

std::vector<RigSensor> read_rig_file(const fs::path& file, const SensorRig& recorded) {
  return read_json_text(read_file(file), file.string(), [&](JsonObject& root) {
    if (root.text("format") != kFormat) {
      throw_input_error(root.file(), "format", '"' + root.text("format") + '"', "\"simuli rig\"");
    }
    (void)root.integer("version", 1, 1);
    std::set<std::string> names;
    std::vector<RigSensor> sensors = root.objects("sensors", [&](JsonObject& object) {
      RigSensor read = sensor_from_json(object, recorded);
      if (!names.insert(read.sensor.name()).second) {
        throw_input_error(object.file(),
                          object.field("name"),
                          '"' + read.sensor.name() + "\" twice",
                          "one name per sensor");
      }
      return read;
    });
    if (sensors.empty()) throw_input_error(root.file(), "sensors", "none", "at least one");
    return sensors;
  });
}

}  // namespace simuli

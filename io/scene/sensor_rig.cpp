#include "io/scene/sensor_rig.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <system_error>
#include <utility>

#include "host/core/base/close_names.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/spread.hpp"
#include "io/log/sensor_file.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

bool holds(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Returns a built-in sensor, or reads a file if that is allowed; `own` are further suggestions for the error.
Sensor find_named(const std::string& name, bool reads_files, std::vector<std::string> own) {
  std::error_code ignored;
  if (reads_files && (name.ends_with(".json") || fs::is_regular_file(name, ignored))) {
    return sensor_of(read_sensor_file(name)).named(fs::path(name).stem().string());
  }
  const std::vector<std::string> lidars = builtin_lidar_names(), cameras = builtin_camera_names();
  const std::string model = name.substr(0, name.find('@'));
  if (holds(lidars, model)) return Sensor(builtin_lidar(name));
  if (holds(cameras, name)) return Sensor(builtin_camera(name));
  const std::vector<std::string> built_in = builtin_sensor_names();
  std::vector<std::string> known = own;
  known.insert(known.end(), built_in.begin(), built_in.end());
  const std::string meant = did_you_mean(model, known);
  own.emplace_back("those that \"simuli info sensors\" lists");
  throw Error(ErrorKind::kUsage,
              fmt::format("sensor: found \"{}\", {}allowed {}", name, meant, fmt::join(own, ", ")));
}

double median_duration_s(const std::vector<FrameSpan>& spans) {
  std::vector<double> seconds;
  for (const FrameSpan& span : spans) seconds.push_back(span.time_end_s - span.time_start_s);
  return upper_median(std::move(seconds));
}

}  // namespace

std::vector<std::string> builtin_sensor_names() {
  std::vector<std::string> names = builtin_lidar_names();
  for (std::string& camera : builtin_camera_names()) names.push_back(std::move(camera));
  return names;
}

Sensor named_sensor(const std::string& name) { return find_named(name, true, {}); }

SensorRig::SensorRig(const std::vector<LogCamera>& cameras,
                     const std::vector<LogLidar>& lidars,
                     FrameSpans recorded)
    : recorded_(std::move(recorded)) {
  for (const LogCamera& c : cameras) {
    sensors_.emplace_back(c.model, c.rig_from_camera, median_duration_s(recorded_[c.model.name]));
  }
  for (const LogLidar& l : lidars) sensors_.emplace_back(l.model, l.rig_from_lidar);
}

SensorRig::SensorRig(const SceneFile& scene)
    : SensorRig(scene.cameras, scene.lidars, scene.recorded_frames) {}

SensorRig::SensorRig(const Log& log) : SensorRig(log.cameras, log.lidars, frame_spans(log)) {}

const Sensor* SensorRig::own(const std::string& name) const {
  const auto found =
      std::find_if(sensors_.begin(), sensors_.end(), [&](const Sensor& s) { return s.name() == name; });
  return found == sensors_.end() ? nullptr : &*found;
}

bool SensorRig::has(const std::string& name) const { return own(name) != nullptr; }

Sensor SensorRig::other(const std::string& name) const {
  std::vector<std::string> known;
  for (const Sensor& sensor : sensors_) known.push_back(sensor.name());
  return find_named(name, reads_files_, std::move(known));
}

const Sensor* SensorRig::first_like(const Sensor& sensor) const {
  const auto found = std::find_if(
      sensors_.begin(), sensors_.end(), [&](const Sensor& s) { return s.is_camera() == sensor.is_camera(); });
  return found == sensors_.end() ? nullptr : &*found;
}

Sensor SensorRig::find(const std::string& name) const {
  if (const Sensor* const found = own(name)) return *found;
  return in_place(other(name));
}

Sensor SensorRig::in_place(const Sensor& sensor) const {
  const Sensor* const place = first_like(sensor);
  if (place == nullptr) {
    throw_input_error("sensor " + sensor.name(),
                      sensor.is_camera() ? "cameras" : "lidars",
                      "none",
                      "one, in whose place another is to be mounted");
  }
  return sensor.mounted(place->rig_from_sensor());
}

Sensor SensorRig::find(const std::string& name, const Pose& rig_from_other) const {
  if (const Sensor* const found = own(name)) return *found;
  const Sensor sensor = other(name);
  const Sensor* const place = first_like(sensor);
  return sensor.mounted(place == nullptr ? rig_from_other : place->rig_from_sensor());
}

std::vector<FrameSpan> SensorRig::frames(const std::string& name, const Sensor& sensor) const {
  const bool is_own = has(name);
  const Sensor* const place = is_own ? own(name) : first_like(sensor);
  const auto found = place == nullptr ? recorded_.end() : recorded_.find(place->name());
  std::vector<FrameSpan> spans = found == recorded_.end() ? std::vector<FrameSpan>() : found->second;
  if (is_own) return spans;
  for (FrameSpan& span : spans) span.time_end_s = span.time_start_s + sensor.duration_s();
  return spans;
}

void SensorRig::add(const Sensor& sensor) {
  if (has(sensor.name())) {
    throw Error(ErrorKind::kUsage,
                fmt::format("sensor: found \"{}\", which there is already", sensor.name()));
  }
  sensors_.push_back(sensor);
}

}  // namespace simuli

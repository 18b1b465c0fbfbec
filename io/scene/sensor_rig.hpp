#pragma once
// Sensors by name.
#include <string>
#include <vector>

#include "host/core/sensors/sensor.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli {

/// Returns a built-in camera ("tum_vi_cam0") or LiDAR ("hesai_xt32", "hesai_xt32@20": in another mode), or the
/// sensor of a JSON file (io/log/sensor_file.hpp; named by its stem), with an identity mounting. Throws
/// Error{kUsage} with the closest names for an unknown one, Error{kInput} for an unreadable file.
[[nodiscard]] Sensor named_sensor(const std::string& name);

/// Returns the names of LiDARs, then of cameras.
[[nodiscard]] std::vector<std::string> builtin_sensor_names();

/// The sensors of a scene or a log, and other sensors mounted in their place.
class SensorRig {
 public:
  SensorRig() = default;
  /// Other cameras get the median exposure duration of the recorded ones.
  explicit SensorRig(const SceneFile& scene);
  explicit SensorRig(const Log& log);

  /// Returns the rig's own sensors, cameras first.
  [[nodiscard]] const std::vector<Sensor>& sensors() const { return sensors_; }
  [[nodiscard]] bool has(const std::string& name) const;
  /// Returns the rig's sensor of that name, else named_sensor() mounted like the rig's first sensor of that
  /// kind. Errors as there; Error{kInput} if the rig has none of that kind.
  [[nodiscard]] Sensor find(const std::string& name) const;
  /// The same; without a sensor of that kind the other sensor is mounted at `rig_from_other`.
  [[nodiscard]] Sensor find(const std::string& name, const Pose& rig_from_other) const;
  /// Returns another sensor mounted like the rig's first sensor of that kind. Throws Error{kInput} if there is
  /// none.
  [[nodiscard]] Sensor in_place(const Sensor& sensor) const;
  /// Returns the recorded frame times of `sensor`, the result of find(name). Another sensor than the rig's gets
  /// the start times of the sensor that it replaces and its own duration. Empty without recorded frames.
  [[nodiscard]] std::vector<FrameSpan> frames(const std::string& name, const Sensor& sensor) const;
  /// From now on names never refer to files, for untrusted names.
  void refuse_files() { reads_files_ = false; }
  /// Adds a sensor. Throws Error{kUsage} for a name in use.
  void add(const Sensor& sensor);

 private:
  [[nodiscard]] const Sensor* own(const std::string& name) const;
  [[nodiscard]] const Sensor* first_like(const Sensor& sensor) const;
  /// named_sensor() that also suggests the rig's own names.
  [[nodiscard]] Sensor other(const std::string& name) const;

  SensorRig(const std::vector<LogCamera>& cameras, const std::vector<LogLidar>& lidars, FrameSpans recorded);

  std::vector<Sensor> sensors_;
  FrameSpans recorded_;
  bool reads_files_ = true;
};

}  // namespace simuli

#pragma once
// Sensors by name, for all who ask for one.
#include <string>
#include <vector>

#include "host/core/sensors/sensor.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli {

/// A built-in camera ("tum_vi_cam0") or LiDAR ("hesai_xt32", "hesai_xt32@20": in another mode), or the one
/// of a JSON file (io/log/sensor_file.hpp; named by its stem), at the origin of no rig. Error{kUsage} naming
/// the closest names for one that is not there, Error{kInput} for a file that can't be read.
[[nodiscard]] Sensor named_sensor(const std::string& name);

/// Of LiDARs, then of cameras.
[[nodiscard]] std::vector<std::string> builtin_sensor_names();

/// The sensors of a scene or a log, and in their place any other.
class SensorRig {
 public:
  SensorRig() = default;
  /// Cameras take for a picture what the recorded ones took (the median).
  explicit SensorRig(const SceneFile& scene);
  explicit SensorRig(const Log& log);

  /// Its own sensors: cameras first.
  [[nodiscard]] const std::vector<Sensor>& sensors() const { return sensors_; }
  [[nodiscard]] bool has(const std::string& name) const;
  /// A sensor of its own, else named_sensor() mounted where its first sensor of that kind is. Errors as
  /// those; Error{kInput} where it has none of that kind.
  [[nodiscard]] Sensor find(const std::string& name) const;
  /// The same; where it has none of that kind, the other is mounted there.
  [[nodiscard]] Sensor find(const std::string& name, const Pose& rig_from_other) const;
  /// Another sensor, mounted where its first of that kind is. Error{kInput} where it has none.
  [[nodiscard]] Sensor in_place(const Sensor& sensor) const;
  /// When the frames of `sensor`, which is what find(name) gave, were recorded. Of another than its own:
  /// when those of the sensor in whose place it stands began, and as long as it takes. None where none were.
  [[nodiscard]] std::vector<FrameSpan> frames(const std::string& name, const Sensor& sensor) const;
  /// From now on no name is a file: for names that others send.
  void refuse_files() { reads_files_ = false; }
  /// One more of its own. Error{kUsage} for a name that it has already.
  void add(const Sensor& sensor);

 private:
  [[nodiscard]] const Sensor* own(const std::string& name) const;
  [[nodiscard]] const Sensor* first_like(const Sensor& sensor) const;
  /// named_sensor() that also knows the rig's own names.
  [[nodiscard]] Sensor other(const std::string& name) const;

  SensorRig(const std::vector<LogCamera>& cameras, const std::vector<LogLidar>& lidars, FrameSpans recorded);

  std::vector<Sensor> sensors_;
  FrameSpans recorded_;
  bool reads_files_ = true;
};

}  // namespace simuli

#pragma once
// A user-defined rig as a JSON file: any number of sensors with mountings.
//
//   {"format": "simuli rig", "version": 1, "sensors": [
//     {"name": "roof", "sensor": "hesai_pandar64",
//      "mount": {"position_m": [0.2, 0, 1.9], "roll_deg": 0, "pitch_deg": 5, "yaw_deg": 90}},
//     {"name": "left", "sensor": "tum_vi_cam0", "width_px": 640, "height_px": 480, "readout_s": 0.03,
//      "rig_from_sensor": {"position_m": [...], "rotation_wxyz": [...]}},
//     {"name": "ahead", "sensor": {"kind": "camera", ...}}]}
//
// name: unique, used for the sensor's files. sensor: a name as in SensorRig::find(), with files relative to this
// file, or the content of such a file. mount: as Mounting (host/core/scene/mounting.hpp), missing angles are 0; or
// rig_from_sensor as in frames.json. A sensor with neither is mounted as recorded, or like the first sensor of its
// kind. width_px, height_px: of cameras, both or neither. readout_s: of a rolling shutter, unless the camera was
// recorded, because its frames determine it.
#include <filesystem>
#include <string>
#include <vector>

#include "io/scene/sensor_rig.hpp"

namespace simuli {

struct RigSensor {
  Sensor sensor;      // with the name and mounting of the file
  std::string model;  // as SensorRig::frames() takes it
};

/// Reads a rig; names refer to `recorded`. Throws Error{kInput} naming file and field for invalid syntax,
/// missing, unknown or repeated keys, an empty rig, and impossible sensors.
[[nodiscard]] std::vector<RigSensor> read_rig_file(const std::filesystem::path& file,
                                                   const SensorRig& recorded);

}  // namespace simuli

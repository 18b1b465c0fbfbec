#pragma once
// A rig of one's own: any number of sensors, each with its place, as a JSON file.
//
//   {"format": "simuli rig", "version": 1, "sensors": [
//     {"name": "roof", "sensor": "hesai_pandar64",
//      "mount": {"position_m": [0.2, 0, 1.9], "roll_deg": 0, "pitch_deg": 5, "yaw_deg": 90}},
//     {"name": "left", "sensor": "tum_vi_cam0", "width_px": 640, "height_px": 480, "readout_s": 0.03,
//      "rig_from_sensor": {"position_m": [...], "rotation_wxyz": [...]}},
//     {"name": "ahead", "sensor": {"kind": "camera", ...}}]}
//
// name: of the sensor's files, each once. sensor: as SensorRig::find() takes it, files beside this one; or
// the content of such a file. mount: as of Mounting (host/core/scene/mounting.hpp), angles that are missing are 0;
// or rig_from_sensor, as frames.json has it. A sensor with neither stands where it was recorded, or in the
// place of the first of its kind. width_px, height_px: of cameras, both or neither. readout_s: of a rolling
// shutter, unless the camera is a recorded one, whose frames say it.
#include <filesystem>
#include <string>
#include <vector>

#include "io/scene/sensor_rig.hpp"

namespace simuli {

struct RigSensor {
  Sensor sensor;      // named and mounted as the file says
  std::string model;  // as SensorRig::frames() takes it
};

/// With the names of `recorded`. Error{kInput} naming file and field for bad syntax, missing, unknown or
/// twice written keys, no sensor at all, and sensors that can't be.
[[nodiscard]] std::vector<RigSensor> read_rig_file(const std::filesystem::path& file,
                                                   const SensorRig& recorded);

}  // namespace simuli

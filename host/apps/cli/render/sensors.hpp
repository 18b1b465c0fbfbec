#pragma once
// Sensors of `simuli render`: selection, mounting, picture size.
#include <string>
#include <vector>

#include "host/apps/cli/base/command.hpp"
#include "io/scene/rig_file.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli::cli {

/// Options as given on the command line.
struct SensorOptions {
  std::vector<std::string> names;
  std::string rig;    // file (io/scene/rig_file.hpp) instead of names
  std::string mount;  // x,y,z,roll,pitch,yaw in m and degrees; empty: unchanged
  std::string size;   // WxH; empty: the camera's size times the scale
  double scale = 1.0;
  double lane_shift_m = 0.0;
};

void add_sensor_options(Command sub, SensorOptions& options);

/// Returns at least one sensor, mounted on the shifted rig, with the requested picture size and, if not
/// negative, the duration of --duration. A LiDAR's --duration 0 applies to the frame (the scene is static
/// during the revolution); the beams still fire in sequence. Errors as in SensorRig::find() and
/// read_rig_file(); throws Error{kUsage} for contradicting options.
[[nodiscard]] std::vector<RigSensor> find_sensors(const SceneFile& file,
                                                  const SensorOptions& options,
                                                  double duration_s);

}  // namespace simuli::cli

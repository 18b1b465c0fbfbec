#pragma once
// Which sensors `simuli render` renders, where they are mounted, and how large their pictures are.
#include <string>
#include <vector>

#include "host/apps/cli/base/command.hpp"
#include "io/scene/rig_file.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli::cli {

/// As asked for on the command line.
struct SensorOptions {
  std::vector<std::string> names;
  std::string rig;    // a file (io/scene/rig_file.hpp) instead of names
  std::string mount;  // x,y,z,roll,pitch,yaw in m and degrees; empty: where it is
  std::string size;   // WxH; empty: as the camera says, times the scale
  double scale = 1.0;
  double lane_shift_m = 0.0;
};

void add_sensor_options(Command sub, SensorOptions& options);

/// One at least: mounted on the rig that was moved aside, pictures of their size, frames of --duration where
/// that is not negative. A LiDAR's --duration 0 is a frame's (all stands still while it turns), not the
/// LiDAR's, whose beams still fire one after the other. Errors as SensorRig::find() and read_rig_file();
/// Error{kUsage} for options that can't be.
[[nodiscard]] std::vector<RigSensor> find_sensors(const SceneFile& file,
                                                  const SensorOptions& options,
                                                  double duration_s);

}  // namespace simuli::cli

#pragma once
// Which frames `simuli render` renders: the path, and every frame's start and end on it.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/apps/cli/base/command.hpp"
#include "host/core/sensors/sensor.hpp"
#include "host/core/sensors/trajectory.hpp"
#include "host/device/render/scene/shot.hpp"
#include "io/scene/rig_file.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli::cli {

/// As asked for on the command line.
struct PlanOptions {
  std::string trajectory = "recorded";
  std::string times;         // t0:t1:dt, s
  std::string frames;        // a:b
  double duration_s = -1.0;  // of one frame; below 0: as the sensor says
  double speed = 1.0;        // of the rig over the recorded
};

void add_plan_options(Command sub, PlanOptions& options);

struct Plan {
  Trajectory world_from_rig;
  std::vector<FrameSpan> spans;
  std::size_t first = 0;  // number of the first span's frame

  [[nodiscard]] Shot shot(const Sensor& sensor, std::size_t i) const;
};

/// A path, and what was recorded along it.
struct Drive {
  std::string source;  // the folder that it is of
  Trajectory world_from_rig;
  SensorRig recorded;
  std::optional<std::int64_t> start_ns = {};  // of a log: nanoseconds since 1970 of its time 0
};

/// The path of --trajectory: that of the scene in the folder `scene`, or a log's. Error{kInput} where there
/// is none.
[[nodiscard]] Drive read_drive(const std::string& scene, const SceneFile& file, const PlanOptions& options);

/// The frames of `sensor`. Error{kUsage} for options that can't be, Error{kInput} where there is no frame.
[[nodiscard]] Plan make_plan(const Drive& drive, const RigSensor& sensor, const PlanOptions& options);

}  // namespace simuli::cli

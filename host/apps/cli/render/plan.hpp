#pragma once
// Selection of frames for `simuli render`: the trajectory, and each frame's start and end time.
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

/// Options as given on the command line.
struct PlanOptions {
  std::string trajectory = "recorded";
  std::string times;         // t0:t1:dt, s
  std::string frames;        // a:b
  double duration_s = -1.0;  // of one frame; negative: the sensor's
  double speed = 1.0;        // factor on the ego vehicle's speed
};

void add_plan_options(Command sub, PlanOptions& options);

struct Plan {
  Trajectory world_from_rig;
  std::vector<FrameSpan> spans;
  std::size_t first = 0;  // number of the frame of the first span

  [[nodiscard]] Shot shot(const Sensor& sensor, std::size_t i) const;
};

/// A trajectory and the frames that were recorded along it.
struct Drive {
  std::string source;  // folder of the scene or the log
  Trajectory world_from_rig;
  SensorRig recorded;
  std::optional<std::int64_t> start_ns = {};  // of a log: nanoseconds since 1970 of its time 0
};

/// Returns the trajectory of --trajectory: that of the scene in the folder `scene`, or a log's. Throws
/// Error{kInput} without a trajectory.
[[nodiscard]] Drive read_drive(const std::string& scene, const SceneFile& file, const PlanOptions& options);

/// Returns the frames of `sensor`. Throws Error{kUsage} for contradicting options, Error{kInput} without any
/// frame.
[[nodiscard]] Plan make_plan(const Drive& drive, const RigSensor& sensor, const PlanOptions& options);

}  // namespace simuli::cli

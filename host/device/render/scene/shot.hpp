#pragma once
// Poses and times of a sensor during one frame, and edits for that frame.
#include <vector>

#include "host/core/base/pose.hpp"
#include "host/core/scene/actor.hpp"
#include "host/core/scene/edit.hpp"
#include "host/core/scene/scene.hpp"
#include "host/core/sensors/sensor.hpp"
#include "host/core/sensors/trajectory.hpp"

namespace simuli {

/// World coordinates (m), seconds of the scene's log.
struct Shot {
  Pose world_from_sensor_start;
  Pose world_from_sensor_end;
  double time_start_s = 0.0;
  double time_end_s = 0.0;
  std::vector<ActorEdit> edits = {};  // applied in order to this frame only

  /// A sensor at rest. The duration is that of a rolling shutter or a LiDAR revolution, during which actors
  /// move.
  [[nodiscard]] static Shot at(const Pose& world_from_sensor, double time_s, double duration_s = 0.0);
  /// `sensor` on a rig at rest, for the sensor's own duration.
  [[nodiscard]] static Shot at(const Sensor& sensor, const Pose& world_from_rig, double time_s);
  /// A sensor moving along a trajectory. Throws as Trajectory::at().
  [[nodiscard]] static Shot along(const Trajectory& world_from_rig,
                                  const Pose& rig_from_sensor,
                                  double time_start_s,
                                  double time_end_s);
  /// `sensor` on the rig, for the sensor's own duration.
  [[nodiscard]] static Shot along(const Trajectory& world_from_rig,
                                  const Sensor& sensor,
                                  double time_start_s);

  [[nodiscard]] double middle_s() const { return 0.5 * (time_start_s + time_end_s); }
  /// world_from_sensor at that share of the frame.
  [[nodiscard]] Pose pose_at(double share) const;
  /// The shot with the rig, on which the sensor is mounted at rig_from_sensor, shifted to its left.
  [[nodiscard]] Shot shifted_left(const Pose& rig_from_sensor, double left_m) const;
  /// The shot in coordinates relative to `origin`.
  [[nodiscard]] Shot relative_to(const Eigen::Vector3d& origin) const;
};

/// Views of `actors` during the shot, in order, after its edits. Throws Error{kUsage} for edits of other
/// actors.
[[nodiscard]] std::vector<ActorView> actors_during(const std::vector<Actor>& actors,
                                                   const Shot& shot,
                                                   const Eigen::Vector3d& scene_origin);
/// Views of all owners of the scene's particles (occluders.hpp).
[[nodiscard]] std::vector<ActorView> owners_during(const Scene& scene, const Shot& shot, SetKind kind);

}  // namespace simuli

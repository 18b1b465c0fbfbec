#pragma once
// Where a sensor is, and when, while it takes one frame; and what is edited for that frame alone.
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
  std::vector<ActorEdit> edits = {};  // of this frame, one after the other; the scene stays as it is

  /// A sensor at rest. The duration is of a rolling shutter or a LiDAR's turn, in which actors go on.
  [[nodiscard]] static Shot at(const Pose& world_from_sensor, double time_s, double duration_s = 0.0);
  /// `sensor` on a rig at rest, for as long as it takes.
  [[nodiscard]] static Shot at(const Sensor& sensor, const Pose& world_from_rig, double time_s);
  /// A sensor that is carried along a path. Errors as Trajectory::at().
  [[nodiscard]] static Shot along(const Trajectory& world_from_rig,
                                  const Pose& rig_from_sensor,
                                  double time_start_s,
                                  double time_end_s);
  /// `sensor` on the rig, for as long as it takes.
  [[nodiscard]] static Shot along(const Trajectory& world_from_rig,
                                  const Sensor& sensor,
                                  double time_start_s);

  [[nodiscard]] double middle_s() const { return 0.5 * (time_start_s + time_end_s); }
  /// world_from_sensor at that share of the frame.
  [[nodiscard]] Pose pose_at(double share) const;
  /// With the rig, which the sensor sits on at rig_from_sensor, that far to the left of where it was.
  [[nodiscard]] Shot shifted_left(const Pose& rig_from_sensor, double left_m) const;
  /// Coordinates relative to `origin` instead of the world's.
  [[nodiscard]] Shot relative_to(const Eigen::Vector3d& origin) const;
};

/// `actors` during the shot, in their order, after its edits. Error{kUsage} for edits of others.
[[nodiscard]] std::vector<ActorView> actors_during(const std::vector<Actor>& actors,
                                                   const Shot& shot,
                                                   const Eigen::Vector3d& scene_origin);
/// The same of all that particles of the scene belong to (occluders.hpp).
[[nodiscard]] std::vector<ActorView> owners_during(const Scene& scene, const Shot& shot, SetKind kind);

}  // namespace simuli

#pragma once
// Which pixels and rays of a frame look at an actor: the part of the metrics that is about what moves.
#include <Eigen/Core>
#include <vector>

#include "host/render/scene/view.hpp"
#include "host/scene/actor.hpp"
#include "host/sensors/camera.hpp"
#include "host/sensors/lidar_model.hpp"

namespace simuli {

/// Actors' boxes during a frame. Rays meet them where they are at the ray's own time.
class ActorBoxes {
 public:
  /// `view` with the poses of `actors`, in their order (frames.hpp).
  ActorBoxes(const std::vector<Actor>& actors, const View& view);
  /// Whether the ray from a point of the sensor frame, at that share of the frame, meets a box.
  [[nodiscard]] bool are_met(const Eigen::Vector3d& origin,
                             const Eigen::Vector3d& direction,
                             double time_fraction) const;
  /// Whether the point at `range` m along that ray is inside a box.
  [[nodiscard]] bool contain(const Eigen::Vector3d& origin,
                             const Eigen::Vector3d& direction,
                             double range,
                             double time_fraction) const;

 private:
  [[nodiscard]] Pose actor_from_sensor(std::size_t actor, double time_fraction) const;

  std::vector<Eigen::Vector3d> half_;  // m
  View view_;
};

/// [height][width]: pixels whose ray meets a box, whatever stands before it.
[[nodiscard]] std::vector<bool> pixels_on_actors(const ActorBoxes& boxes, const Camera& camera);

/// [rays]: rays whose recorded return is inside a box. range: [rays] m, 0 for no return.
[[nodiscard]] std::vector<bool> returns_on_actors(const ActorBoxes& boxes,
                                                  const LidarModel& lidar,
                                                  const LidarRays& rays,
                                                  const std::vector<float>& range);

}  // namespace simuli

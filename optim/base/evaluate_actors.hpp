#pragma once
// Which pixels and rays of a frame look at an actor: the part of the metrics that is about what moves.
#include <Eigen/Core>
#include <vector>

#include "host/core/scene/actor.hpp"
#include "host/core/sensors/camera.hpp"
#include "host/core/sensors/lidar_model.hpp"
#include "host/device/render/scene/view.hpp"

namespace simuli {

/// Of a line, in lengths of its direction: from behind its origin on. first > last: nothing of it.
struct BoxInterval {
  double first, last;
};
/// What of a line lies in the box of half sides `half` about the frame's origin.
[[nodiscard]] BoxInterval inside_box(const Eigen::Vector3d& origin,
                                     const Eigen::Vector3d& direction,
                                     const Eigen::Vector3d& half);

/// Actors' boxes during a frame. Rays meet them where they are at the ray's own time.
class ActorBoxes {
 public:
  /// `view` with the poses of `actors`, in their order (frames.hpp).
  ActorBoxes(const std::vector<Actor>& actors, const View& view);
  static constexpr int kNone = -1;
  /// The actor whose box the ray from a point of the sensor frame, at that share of the frame, enters first;
  /// kNone: it meets none.
  [[nodiscard]] int met_first(const Eigen::Vector3d& origin,
                              const Eigen::Vector3d& direction,
                              double time_fraction) const;
  /// The first actor whose box the point at `range` m along that ray is in; kNone: it is in none.
  [[nodiscard]] int around(const Eigen::Vector3d& origin,
                           const Eigen::Vector3d& direction,
                           double range,
                           double time_fraction) const;

 private:
  [[nodiscard]] Pose actor_from_sensor(std::size_t actor, double time_fraction) const;

  std::vector<Eigen::Vector3d> half_;  // m
  View view_;
};

/// [height][width]: the actor whose box the pixel's ray meets first, whatever stands before it; kNone: none.
[[nodiscard]] std::vector<int> pixels_on_actors(const ActorBoxes& boxes, const Camera& camera);

/// [rays]: the actor whose box the ray's recorded return is in; kNone: none. range: [rays] m, 0 for no
/// return.
[[nodiscard]] std::vector<int> returns_on_actors(const ActorBoxes& boxes,
                                                 const LidarModel& lidar,
                                                 const LidarRays& rays,
                                                 const std::vector<float>& range);

}  // namespace simuli

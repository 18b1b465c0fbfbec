#pragma once
// Intersection of rays with actors' boxes.
#include <Eigen/Core>
#include <vector>

#include "host/core/scene/actor.hpp"
#include "host/device/render/scene/view.hpp"

namespace simuli {

/// An interval along a line in lengths of its direction; may begin before the origin. first > last: empty.
struct BoxInterval {
  double first, last;
};
/// Returns the interval of a line inside the box with half sides `half` about the frame's origin.
[[nodiscard]] BoxInterval inside_box(const Eigen::Vector3d& origin,
                                     const Eigen::Vector3d& direction,
                                     const Eigen::Vector3d& half);

/// Actors' boxes during a frame, at their poses at each ray's own time.
class ActorBoxes {
 public:
  /// `view` with the poses of `actors`, in the same order.
  ActorBoxes(const std::vector<Actor>& actors, View view);
  static constexpr int kNone = -1;
  /// Returns the actor whose box the ray from a point of the sensor frame, at that share of the frame, enters
  /// first; kNone without one.
  [[nodiscard]] int met_first(const Eigen::Vector3d& origin,
                              const Eigen::Vector3d& direction,
                              double time_fraction) const;
  /// Returns the first actor whose box contains the point at `range` m along that ray; kNone without one.
  [[nodiscard]] int around(const Eigen::Vector3d& origin,
                           const Eigen::Vector3d& direction,
                           double range,
                           double time_fraction) const;
  /// Whether a point of the sensor frame on the actor belongs to its body: inside its box, enlarged by
  /// kBodyMargin_m because labels are inexact, and above the lowest kBelowBody_m, which contain road and
  /// shadow.
  [[nodiscard]] bool is_of_body(std::size_t actor,
                                const Eigen::Vector3d& p_sensor,
                                double time_fraction) const;
  static constexpr double kBodyMargin_m = 0.1;
  static constexpr double kBelowBody_m = 0.05;

  [[nodiscard]] std::size_t size() const { return half_.size(); }
  [[nodiscard]] const Eigen::Vector3d& half_m(std::size_t actor) const { return half_[actor]; }
  [[nodiscard]] const View& view() const { return view_; }
  [[nodiscard]] Pose actor_from_sensor(std::size_t actor, double time_fraction) const;

 private:
  [[nodiscard]] Pose scene_from_sensor(double time_fraction) const;
  [[nodiscard]] Pose actor_from_scene(std::size_t actor, double time_fraction) const;
  /// Whether the line hits the bounding ball of the actor's box, a quick rejection test.
  [[nodiscard]] bool is_within_ball(std::size_t actor,
                                    const Eigen::Vector3d& p_scene,
                                    const Eigen::Vector3d& direction_scene,
                                    double time_fraction) const;

  std::vector<Eigen::Vector3d> half_;  // m
  View view_;
};

}  // namespace simuli

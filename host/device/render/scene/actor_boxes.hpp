#pragma once
// Actors' boxes as rays meet them.
#include <Eigen/Core>
#include <vector>

#include "host/core/scene/actor.hpp"
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
  /// `view` with the poses of `actors`, in their order.
  ActorBoxes(const std::vector<Actor>& actors, View view);
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
  /// Whether what a ray met of the actor, at a point of the sensor frame, is of its body: in its box, which is
  /// grown by kBodyMargin_m, as labels are not exact, and above the lowest kBelowBody_m, where the road lies
  /// with what shadow the actor casts.
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
  /// Whether the line meets the ball about the actor's box: most lines are far from most boxes.
  [[nodiscard]] bool is_within_ball(std::size_t actor,
                                    const Eigen::Vector3d& p_scene,
                                    const Eigen::Vector3d& direction_scene,
                                    double time_fraction) const;

  std::vector<Eigen::Vector3d> half_;  // m
  View view_;
};

}  // namespace simuli

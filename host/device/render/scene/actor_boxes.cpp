#include "host/device/render/scene/actor_boxes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace simuli {

BoxInterval inside_box(const Eigen::Vector3d& origin,
                       const Eigen::Vector3d& direction,
                       const Eigen::Vector3d& half) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  BoxInterval in{-kInf, kInf};
  for (Eigen::Index k = 0; k < 3; ++k) {
    if (direction(k) == 0.0) {
      if (std::abs(origin(k)) > half(k)) return {kInf, -kInf};
      continue;
    }
    const double a = (-half(k) - origin(k)) / direction(k), b = (half(k) - origin(k)) / direction(k);
    in.first = std::max(in.first, std::min(a, b));
    in.last = std::min(in.last, std::max(a, b));
  }
  return in;
}

ActorBoxes::ActorBoxes(const std::vector<Actor>& actors, View view) : view_(std::move(view)) {
  for (const Actor& actor : actors) half_.emplace_back(0.5 * actor.size_m);
}

Pose ActorBoxes::scene_from_sensor(double time_fraction) const {
  return interpolate(view_.scene_from_sensor_start, view_.scene_from_sensor_end, time_fraction);
}

Pose ActorBoxes::actor_from_scene(std::size_t actor, double time_fraction) const {
  const ActorView& poses = view_.actors[actor];
  return interpolate(poses.scene_from_actor_start, poses.scene_from_actor_end, time_fraction).inverse();
}

Pose ActorBoxes::actor_from_sensor(std::size_t actor, double time_fraction) const {
  return actor_from_scene(actor, time_fraction) * scene_from_sensor(time_fraction);
}

bool ActorBoxes::is_within_ball(std::size_t actor,
                                const Eigen::Vector3d& p_scene,
                                const Eigen::Vector3d& direction_scene,
                                double time_fraction) const {
  const ActorView& poses = view_.actors[actor];
  const Eigen::Vector3d &start = poses.scene_from_actor_start.translation,
                        &end = poses.scene_from_actor_end.translation;
  const Eigen::Vector3d to_center = start + time_fraction * (end - start) - p_scene;
  constexpr double kRounding = 1.0 + 1e-6;
  return to_center.cross(direction_scene).squaredNorm() <=
         kRounding * half_[actor].squaredNorm() * direction_scene.squaredNorm();
}

int ActorBoxes::met_first(const Eigen::Vector3d& origin,
                          const Eigen::Vector3d& direction,
                          double time_fraction) const {
  int first = kNone;
  double nearest = std::numeric_limits<double>::infinity();
  const Pose to_scene = scene_from_sensor(time_fraction);
  const Eigen::Vector3d p_scene = to_scene * origin, d_scene = to_scene.rotation * direction;
  for (std::size_t i = 0; i < half_.size(); ++i) {
    if (!view_.actors[i].is_there || !is_within_ball(i, p_scene, d_scene, time_fraction)) continue;
    const Pose to_actor = actor_from_scene(i, time_fraction) * to_scene;
    const Eigen::Vector3d o = to_actor * origin;
    const Eigen::Vector3d d = to_actor.rotation * direction;
    const BoxInterval in = inside_box(o, d, half_[i]);
    const double enter = std::max(in.first, 0.0), leave = in.last;
    if (enter > leave || enter >= nearest) continue;
    nearest = enter;
    first = static_cast<int>(i);
  }
  return first;
}

int ActorBoxes::around(const Eigen::Vector3d& origin,
                       const Eigen::Vector3d& direction,
                       double range,
                       double time_fraction) const {
  const Pose to_scene = scene_from_sensor(time_fraction);
  const Eigen::Vector3d p_sensor = origin + range * direction;
  const Eigen::Vector3d p_scene = to_scene * origin, d_scene = to_scene.rotation * direction;
  for (std::size_t i = 0; i < half_.size(); ++i) {
    if (!view_.actors[i].is_there || !is_within_ball(i, p_scene, d_scene, time_fraction)) continue;
    const Eigen::Vector3d p = (actor_from_scene(i, time_fraction) * to_scene) * p_sensor;
    if ((p.array().abs() <= half_[i].array()).all()) return static_cast<int>(i);
  }
  return kNone;
}

bool ActorBoxes::is_of_body(std::size_t actor, const Eigen::Vector3d& p_sensor, double time_fraction) const {
  if (!view_.actors[actor].is_there) return false;
  const Eigen::Vector3d p = actor_from_sensor(actor, time_fraction) * p_sensor;
  const Eigen::Vector3d& half = half_[actor];
  // Lower objects lie on the road itself.
  const double lowest = -half.z() + std::min(kBelowBody_m, 0.25 * half.z());
  return p.z() >= lowest && (p.array().abs() <= half.array() + kBodyMargin_m).all();
}

}  // namespace simuli

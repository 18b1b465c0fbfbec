#include "host/device/render/scene/shot.hpp"

#include "host/core/scene/occluders.hpp"
#include "host/device/render/scene/view.hpp"

namespace simuli {

Shot Shot::at(const Pose& world_from_sensor, double time_s, double duration_s) {
  return {world_from_sensor, world_from_sensor, time_s, time_s + duration_s};
}

Shot Shot::at(const Sensor& sensor, const Pose& world_from_rig, double time_s) {
  return at(world_from_rig * sensor.rig_from_sensor(), time_s, sensor.duration_s());
}

Shot Shot::along(const Trajectory& world_from_rig,
                 const Pose& rig_from_sensor,
                 double time_start_s,
                 double time_end_s) {
  return {world_from_rig.at(time_start_s) * rig_from_sensor,
          world_from_rig.at(time_end_s) * rig_from_sensor,
          time_start_s,
          time_end_s};
}

Shot Shot::along(const Trajectory& world_from_rig, const Sensor& sensor, double time_start_s) {
  return along(world_from_rig, sensor.rig_from_sensor(), time_start_s, time_start_s + sensor.duration_s());
}

Pose Shot::pose_at(double share) const {
  return interpolate(world_from_sensor_start, world_from_sensor_end, share);
}

Shot Shot::shifted_left(const Pose& rig_from_sensor, double left_m) const {
  const Pose rig_from_moved{Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.0, left_m, 0.0)};
  const Pose sensor_from_moved = rig_from_sensor.inverse() * rig_from_moved * rig_from_sensor;
  Shot out = *this;
  out.world_from_sensor_start = world_from_sensor_start * sensor_from_moved;
  out.world_from_sensor_end = world_from_sensor_end * sensor_from_moved;
  return out;
}

Shot Shot::relative_to(const Eigen::Vector3d& origin) const {
  Shot moved = *this;
  moved.world_from_sensor_start.translation -= origin;
  moved.world_from_sensor_end.translation -= origin;
  return moved;
}

std::vector<ActorView> actors_during(const std::vector<Actor>& actors,
                                     const Shot& shot,
                                     const Eigen::Vector3d& scene_origin) {
  const auto views = [&](const std::vector<Actor>& all) {
    return actors_during(all, shot.time_start_s, shot.time_end_s, scene_origin);
  };
  return shot.edits.empty() ? views(actors) : views(edited(actors, shot.edits));
}

std::vector<ActorView> owners_during(const Scene& scene, const Shot& shot, SetKind kind) {
  std::optional<Eigen::Vector3d> eye;
  if (kind == SetKind::kCamera) eye = shot.pose_at(0.5).translation;
  const auto views = [&](const std::vector<Actor>& actors) {
    return owners_during(scene, actors, shot.time_start_s, shot.time_end_s, eye);
  };
  return shot.edits.empty() ? views(scene.actors) : views(edited(scene.actors, shot.edits));
}

View view_of(const Scene& scene, const Shot& shot, SetKind kind) {
  const Shot in_scene = shot.relative_to(scene.origin);
  return {in_scene.world_from_sensor_start,
          in_scene.world_from_sensor_end,
          kind == SetKind::kCamera ? scene.camera_background : scene.lidar_background,
          owners_during(scene, shot, kind)};
}

}  // namespace simuli

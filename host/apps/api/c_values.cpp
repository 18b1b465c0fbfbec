// Conversion of numbers and names of the C API.
#include <cmath>
#include <fmt/ranges.h>

#include "host/apps/api/c_handles.hpp"

namespace simuli::capi {

std::string& last_error() {
  thread_local std::string text;
  return text;
}

void need_length(const char* argument, std::size_t found, std::size_t allowed) {
  if (found == allowed) return;
  throw Error(ErrorKind::kUsage, fmt::format("{}: found {}, allowed {}", argument, found, allowed));
}

Pose pose_of(const simuli_pose& p) {
  const Eigen::Quaterniond q(p.rotation_wxyz[0], p.rotation_wxyz[1], p.rotation_wxyz[2], p.rotation_wxyz[3]);
  const Eigen::Vector3d position(p.position_m);
  const double norm = q.norm();
  if (!(norm > 0.0) || !std::isfinite(norm) || !position.allFinite()) {
    throw Error(ErrorKind::kUsage, "pose: found a zero quaternion or a non-finite number");
  }
  return {q.normalized(), position};
}

simuli_pose to_c(const Pose& p) {
  const Eigen::Quaterniond& q = p.rotation;
  const Eigen::Vector3d& t = p.translation;
  return {{t.x(), t.y(), t.z()}, {q.w(), q.x(), q.y(), q.z()}};
}

Shot shot_of(const simuli_shot& s) {
  if (!(s.time_end_s >= s.time_start_s) || !std::isfinite(s.time_end_s) || !std::isfinite(s.time_start_s)) {
    throw Error(ErrorKind::kUsage, "shot: found an end before its start or a non-finite time");
  }
  return {pose_of(s.world_from_sensor_start), pose_of(s.world_from_sensor_end), s.time_start_s, s.time_end_s};
}

std::string quality_of(const simuli_options* options) {
  return options == nullptr ? "" : text(options->quality);
}

std::vector<std::string> settings_of(const simuli_options* options) {
  std::vector<std::string> out;
  if (options == nullptr || options->setting_count == 0) return out;
  const char* const* const from = &need(options->settings, "settings");
  for (std::size_t i = 0; i < options->setting_count; ++i) out.emplace_back(&need(from[i], "settings"));
  return out;
}

ActorEdit edit_of(const simuli_edit& edit) {
  ActorEdit out{&need(edit.actor, "actor"), ActorEdit::Remove{}};
  switch (edit.kind) {
    case SIMULI_REMOVE:
      return out;
    case SIMULI_MOVE:
      out.change = ActorEdit::Move{Eigen::Vector3d(edit.by_m)};
      return out;
    case SIMULI_RETIME:
      out.change = ActorEdit::Retime{edit.rate, edit.delay_s};
      return out;
    case SIMULI_RETRACK: {
      ActorEdit::Retrack track;
      for (std::size_t i = 0; i < edit.pose_count; ++i) {
        track.track.push_back({(&need(edit.times_s, "times_s"))[i],
                               pose_of((&need(edit.world_from_actor, "world_from_actor"))[i])});
      }
      out.change = std::move(track);
      return out;
    }
    case SIMULI_TURN:
      out.change = ActorEdit::Turn{edit.yaw_rad};
      return out;
    case SIMULI_DUPLICATE:
      break;
  }
  throw Error(ErrorKind::kUsage,
              fmt::format("edit: found kind {}, allowed {} to {}, {}",
                          static_cast<int>(edit.kind),
                          static_cast<int>(SIMULI_REMOVE),
                          static_cast<int>(SIMULI_RETRACK),
                          static_cast<int>(SIMULI_TURN)));
}

Sensor sensor_of(const simuli_scene& scene, const char* name) {
  const std::string wanted = &need(name, "name");
  if (scene.rig.has(wanted)) return scene.rig.find(wanted);
  std::vector<std::string> known;
  for (const Sensor& sensor : scene.rig.sensors()) known.push_back(sensor.name());
  throw Error(ErrorKind::kUsage,
              fmt::format("name: found \"{}\", allowed {}", wanted, fmt::join(known, ", ")));
}

}  // namespace simuli::capi

#include "host/apps/serve/messages/shot_message.hpp"

#include <cmath>
#include <fmt/format.h>
#include <map>
#include <vector>

#include "host/apps/serve/session/refusal.hpp"
#include "host/core/base/close_names.hpp"

namespace simuli::serve {
namespace {

/// Start and end pose of a frame in world coordinates.
struct Poses {
  Pose start, end;
};

Poses poses_of(const ServedScene& scene, const proto::PosePair& pair, const std::string& field) {
  const auto one = [&](bool is_there, const proto_common::Pose& pose, const char* which) {
    const std::string name = fmt::format("{}.{}", field, which);
    if (!is_there) refuse(name, "none", "a pose");
    return scene.world(pose_of(pose, name));
  };
  return {one(pair.has_start_pose(), pair.start_pose(), "start_pose"),
          one(pair.has_end_pose(), pair.end_pose(), "end_pose")};
}

bool same(const Pose& a, const Pose& b) {
  return a.translation == b.translation && a.rotation.coeffs() == b.rotation.coeffs();
}

std::vector<ActorEdit> edits_of(const ServedScene& scene,
                                const FrameMessage& frame,
                                double start_s,
                                double end_s) {
  std::map<std::string, std::vector<KeyPose>> tracks;
  for (const proto::DynamicObject& object : frame.dynamic_objects) {
    const std::string& id = object.track_id();
    const std::string field = fmt::format("dynamic_objects \"{}\"", id);
    if (!has_actor(scene.scene().actors, id)) {
      std::vector<std::string> known;
      for (const Actor& actor : scene.scene().actors) known.push_back(actor.name);
      refuse("dynamic_objects.track_id",
             fmt::format("\"{}\"", id),
             fmt::format(
                 "{}one of the {} that get_dynamic_objects lists", did_you_mean(id, known), known.size()));
    }
    const Poses poses = poses_of(scene, object.pose_pair(), field);
    std::vector<KeyPose> track{{start_s, poses.start}};
    if (end_s > start_s) track.push_back({end_s, poses.end});
    if (!tracks.emplace(id, std::move(track)).second) refuse(field, "twice", "once");
  }
  std::vector<ActorEdit> edits;
  for (const Actor& actor : scene.scene().actors) {
    const auto found = tracks.find(actor.name);
    if (found == tracks.end()) {
      if (scene.is_inserted(actor.name)) continue;
      edits.push_back({actor.name, ActorEdit::Remove{}});
    } else {
      edits.push_back({actor.name, ActorEdit::Retrack{std::move(found->second)}});
    }
  }
  return edits;
}

}  // namespace

proto_common::Pose message_of(const Pose& pose) {
  proto_common::Pose message;
  message.mutable_vec()->set_x(static_cast<float>(pose.translation.x()));
  message.mutable_vec()->set_y(static_cast<float>(pose.translation.y()));
  message.mutable_vec()->set_z(static_cast<float>(pose.translation.z()));
  message.mutable_quat()->set_w(static_cast<float>(pose.rotation.w()));
  message.mutable_quat()->set_x(static_cast<float>(pose.rotation.x()));
  message.mutable_quat()->set_y(static_cast<float>(pose.rotation.y()));
  message.mutable_quat()->set_z(static_cast<float>(pose.rotation.z()));
  return message;
}

Pose pose_of(const proto_common::Pose& message, const std::string& field) {
  constexpr double kTolerance = 1e-3;  // of the quaternion's norm; single precision needs 1e-7
  const proto_common::Vec3& at = message.vec();
  const proto_common::Quat& q = message.quat();
  const Eigen::Vector3d place(at.x(), at.y(), at.z());
  const Eigen::Quaterniond turn(q.w(), q.x(), q.y(), q.z());
  if (!(place.cwiseAbs().maxCoeff() <= kFarthestInScene_m) || !place.allFinite()) {
    refuse(field + ".vec",
           fmt::format("{}, {}, {}", at.x(), at.y(), at.z()),
           fmt::format("finite, within {} m of the scene's origin", kFarthestInScene_m));
  }
  if (!(std::abs(turn.norm() - 1.0) <= kTolerance)) {
    refuse(
        field + ".quat", fmt::format("{}, {}, {}, {}", q.w(), q.x(), q.y(), q.z()), "w, x, y, z of norm 1");
  }
  return {turn.normalized(), place};
}

Shot camera_shot(const ServedScene& scene, const FrameMessage& frame, const Camera& camera) {
  Shot shot = lidar_shot(scene, frame);
  if (camera.shutter == ShutterKind::kGlobal) {
    shot.world_from_sensor_end = shot.world_from_sensor_start;
    shot.time_end_s = shot.time_start_s;
    return shot;
  }
  const bool runs_down =
      camera.shutter == ShutterKind::kTopToBottom || camera.shutter == ShutterKind::kBottomToTop;
  const int lines = runs_down ? camera.height : camera.width;
  if (lines < 2) return shot;
  const double beyond = 0.5 / (lines - 1);  // share of the frame
  const double more_s = beyond * (shot.time_end_s - shot.time_start_s);
  if (!same(shot.world_from_sensor_start, shot.world_from_sensor_end)) {
    const Pose start = shot.pose_at(-beyond), end = shot.pose_at(1.0 + beyond);
    shot.world_from_sensor_start = start;
    shot.world_from_sensor_end = end;
  }
  shot.time_start_s -= more_s;
  shot.time_end_s += more_s;
  return shot;
}

Shot lidar_shot(const ServedScene& scene, const FrameMessage& frame) {
  if (frame.end_us < frame.start_us) {
    refuse("frame_end_us",
           fmt::format("{}", frame.end_us),
           fmt::format("frame_start_us or later, which is {}", frame.start_us));
  }
  const double start_s = scene.seconds(frame.start_us, "frame_start_us");
  const double end_s = scene.seconds(frame.end_us, "frame_end_us");
  const Poses poses = poses_of(scene, frame.sensor_pose, "sensor_pose");
  return {poses.start, poses.end, start_s, end_s, edits_of(scene, frame, start_s, end_s)};
}

}  // namespace simuli::serve

#include <algorithm>

#include "io/export/drive_parts.hpp"
#include "io/export/track_labels.hpp"

namespace simuli {
namespace {

Pose local(Pose world, const Scene& scene) {
  world.translation -= scene.origin;
  return world;
}

Json times_of(const FrameSpans& frames, const std::string& camera, const SceneClock& clock) {
  Json times = Json::array();
  const auto found = frames.find(camera);
  if (found == frames.end()) return times;
  for (const FrameSpan& span : found->second) {
    const std::uint64_t start = clock.microseconds(span.time_start_s);
    times.push_back({start, std::max(start + 1, clock.microseconds(span.time_end_s))});
  }
  return times;
}

/// Returns the poses with distinct times in microseconds.
std::vector<KeyPose> distinct(const Actor& actor, const SceneClock& clock) {
  std::vector<KeyPose> out;
  for (const KeyPose& key : actor.track) {
    if (out.empty() || clock.microseconds(key.time_s) > clock.microseconds(out.back().time_s))
      out.push_back(key);
  }
  if (out.size() == 1) {
    out.push_back(out.front());
    out.back().time_s += Actor::kReach_s;
  }
  return out;
}

}  // namespace

std::vector<Pose> local_path(const SceneFile& scene) {
  std::vector<Pose> out;
  for (const TimedPose& pose : scene.world_from_rig.poses()) out.push_back(local(pose.pose, scene.scene));
  return out;
}

Json rig_trajectories(const SceneFile& file, const SceneClock& clock, const std::string& sequence) {
  const Json identity = rows_of(Eigen::Matrix4d::Identity());
  Json calibrations = Json::object(), frames = Json::object(), poses = Json::array(), times = Json::array();
  for (std::size_t i = 0; i < file.cameras.size(); ++i) {
    const LogCamera& camera = file.cameras[i];
    calibrations[camera.model.name] = camera_calibration(camera, sequence, i);
    frames[camera.model.name] = times_of(file.recorded_frames, camera.model.name, clock);
  }
  for (const Pose& pose : local_path(file)) poses.push_back(rows_of(pose.matrix()));
  for (const TimedPose& pose : file.world_from_rig.poses()) times.push_back(clock.microseconds(pose.time_s));
  return {{"T_world_base", identity},
          {"world_to_nre", {{"matrix", identity}}},
          {"camera_calibrations", calibrations},
          {"rig_trajectories",
           Json::array({{{"sequence_id", sequence},
                         {"T_rig_worlds", poses},
                         {"T_rig_world_timestamps_us", times},
                         {"cameras_frame_timestamps_us", frames},
                         {"rig_bbox", nullptr}}})}};
}

Json sequence_tracks(const Scene& scene, const SceneClock& clock) {
  Json ids = Json::array(), classes = Json::array(), flags = Json::array(), times = Json::array();
  Json poses = Json::array(), sizes = Json::array();
  for (const Actor& actor : scene.actors) {
    if (actor.track.empty()) continue;
    Json own_times = Json::array(), own_poses = Json::array();
    for (const KeyPose& key : distinct(actor, clock)) {
      const Pose pose = local(key.corrected(), scene);
      const Eigen::Vector3d& p = pose.translation;
      const Eigen::Quaterniond& q = pose.rotation;
      own_times.push_back(clock.microseconds(key.time_s));
      own_poses.push_back({p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()});
    }
    ids.push_back(actor.name);
    classes.push_back(label_class_of(actor.kind));
    flags.push_back(actor.track.size() > 1 ? Json::array({"CONTROLLABLE", "DYNAMIC"})
                                           : Json::array({"CONTROLLABLE"}));
    times.push_back(own_times);
    poses.push_back(own_poses);
    sizes.push_back({actor.size_m.x(), actor.size_m.y(), actor.size_m.z()});
  }
  // CARLA's client requires this key.
  return {{"dummy_chunk_id",
           {{"tracks_data",
             {{"tracks_id", ids},
              {"tracks_label_class", classes},
              {"tracks_flags", flags},
              {"tracks_timestamps_us", times},
              {"tracks_poses", poses}}},
            {"cuboidtracks_data", {{"cuboids_dims", sizes}}}}}};
}

}  // namespace simuli

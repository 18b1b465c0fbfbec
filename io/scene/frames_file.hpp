#pragma once
// frames.json: the content and poses of rendered frames, written beside pictures and clouds. With its poses and
// lenses, other programs can use the folder.
#include <filesystem>
#include <string>
#include <vector>

#include "host/core/base/pose.hpp"
#include "host/core/scene/actor_label.hpp"
#include "host/core/sensors/sensor.hpp"

namespace simuli {

/// One frame. World coordinates (m), seconds of the scene's log.
struct FrameRecord {
  std::vector<std::string> files = {};  // beside frames.json
  std::string data = {};   // the file that labels refer to: the picture, or the sweep in nuScenes' format
  std::size_t number = 0;  // of the sensor's frames
  double time_start_s = 0.0, time_end_s = 0.0;
  Pose world_from_sensor_start = {}, world_from_sensor_end = {};
  std::vector<ActorLabel> labels = {};  // of frames with labels
};

/// The number of an actor in masks and clouds.
struct ActorRecord {
  std::size_t id = 0;  // 1, 2, ...; 0: none
  std::string name = {}, kind = {};
  std::size_t class_id = 0;  // 1, 2, ..., equal for equal kinds
};

/// Properties of clouds that their files do not contain.
struct CloudRecord {
  std::string frame = {};        // point_frame_names(); empty: no clouds
  std::string coordinates = {};  // type of x, y and z: "float32", "float64"
};

/// All frames of one sensor.
struct FramesRecord {
  std::string scene = {};                  // name of the scene
  std::string trajectory = {};             // "recorded", or the log of the trajectory
  Sensor sensor;                           // as rendered: size, lens, mounting
  std::vector<std::string> edits = {};     // as on the command line, one per entry
  std::string quality = {};                // quality level of the settings
  std::vector<std::string> settings = {};  // "key=value" of every option, as for --set
  std::string version = {};                // of simuli
  std::string device = {}, driver = {};
  CloudRecord clouds = {};
  std::vector<std::string> outputs = {};  // of a camera, camera_output_names()
  std::vector<ActorRecord> actors = {};   // of frames with actors
  bool has_labels = false;
  std::vector<FrameRecord> frames = {};
};

/// {"format": "simuli frames", "version": 1, "scene", "trajectory", "sensor": as in a sensor file
/// (io/log/sensor_file.hpp), "rig_from_sensor": {"position_m", "rotation_wxyz"}, "edits": [...], "quality",
/// "settings": [...], "simuli", "device", "driver", "clouds": {"frame", "coordinates"} of LiDARs,
/// "outputs": [...] of cameras, "actors": [{"id", "name", "kind", "class"}, ...] if frames contain actors,
/// "frames": [{"files": [...], "time_start_s", "time_end_s", "world_from_sensor_start",
/// "world_from_sensor_end"}, ...]}, with labels also "labels": [{"actor": its id, "time_s", "size_m", the poses
/// "world_from_actor", "rig_from_actor", "sensor_from_actor", "pixels" or "returns", "occlusion" and for cameras
/// "projected_px", "visible_px" and "truncation"}, ...] as in ActorLabel, null for missing values. Cameras look along
/// +z, x right, y down; LiDARs have x forward, y left, z up. Atomic. Throws Error{kInput} if it cannot be written.
void write_frames_file(const std::filesystem::path& file, const FramesRecord& record);

}  // namespace simuli

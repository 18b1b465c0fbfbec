#pragma once
// What was rendered and from where, beside the pictures and clouds: frames.json. With poses and lenses in it
// a folder of frames can be used by programs that know nothing of scenes.
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
  std::string data = {};                // of them, for labels: the picture, or the sweep as nuScenes has it
  std::size_t number = 0;               // of the sensor's frames
  double time_start_s = 0.0, time_end_s = 0.0;
  Pose world_from_sensor_start = {}, world_from_sensor_end = {};
  std::vector<ActorLabel> labels = {};  // of frames with labels
};

/// What the number of an actor stands for, in masks and clouds.
struct ActorRecord {
  std::size_t id = 0;  // 1, 2, ...: 0 is none
  std::string name = {}, kind = {};
  std::size_t class_id = 0;  // 1, 2, ..., the same for the same kind
};

/// What clouds hold beside their own headers.
struct CloudRecord {
  std::string frame = {};        // point_frame_names(); empty: there are no clouds
  std::string coordinates = {};  // type of x, y and z: "float32", "float64"
};

/// All of one sensor.
struct FramesRecord {
  std::string scene = {};                  // its name
  std::string trajectory = {};             // "recorded", or the log that the path is of
  Sensor sensor;                           // as rendered: size, lens, mounting
  std::vector<std::string> edits = {};     // as on the command line, one each
  std::string quality = {};                // the bundle that the settings started from
  std::vector<std::string> settings = {};  // "key=value" of every option, as --set takes them
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
/// "outputs": [...] of cameras, "actors": [{"id", "name", "kind", "class"}, ...] of frames that tell them,
/// "frames": [{"files": [...], "time_start_s", "time_end_s", "world_from_sensor_start",
/// "world_from_sensor_end"}, ...]}, with labels also "labels": [{"actor": its id, "time_s", "size_m", the poses
/// "world_from_actor", "rig_from_actor", "sensor_from_actor", "pixels" or "returns", "occlusion" and of cameras
/// "projected_px", "visible_px" and "truncation"}, ...], as ActorLabel says, null for what there is not. Cameras look along +z, x right, y down; LiDARs have x forward, y left, z up. Atomic. Error{kInput}
/// when it can't be written.
void write_frames_file(const std::filesystem::path& file, const FramesRecord& record);

}  // namespace simuli

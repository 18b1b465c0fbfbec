#pragma once
// Prints the contents of logs, scenes and sensors as text or as JSON with units in the key names.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "io/log/frame_spans.hpp"
#include "io/log/log.hpp"
#include "io/log/sensor_file.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli::cli {

[[nodiscard]] nlohmann::ordered_json log_json(const Log& log);
/// Prints to stdout.
void print_log(const Log& log, bool json);
/// Prints the particles of a splat file.
void print_splats(const std::filesystem::path& file, bool json);
void print_scene(const SceneFile& scene, bool json);
void print_sensor(const CameraFile& camera, bool json);
void print_sensor(const LidarFile& lidar, bool json);

/// Prints all built-in sensors, one line each.
void print_sensor_names(const std::vector<std::string>& cameras,
                        const std::vector<std::string>& lidars,
                        bool json);

/// Returns one line of a list of sensors, without a line end.
[[nodiscard]] std::string lidar_line(const LidarModel& lidar);
[[nodiscard]] std::string camera_line(const Camera& camera);
/// Returns the same as JSON, without beams and rays.
[[nodiscard]] nlohmann::ordered_json lidar_summary(const LidarModel& lidar);
[[nodiscard]] nlohmann::ordered_json camera_summary(const Camera& camera);

/// Returns a summary of a particle set as JSON or as one line.
[[nodiscard]] nlohmann::ordered_json set_json(const GaussianSet& set);
[[nodiscard]] std::string set_text(const char* name, const GaussianSet& set);

/// Times of the recordings of a sensor.
struct Recorded {
  std::size_t frames = 0;
  double start_s = 0.0, end_s = 0.0;  // of the first and the last frame; 0 without frames
  double rate_hz = 0.0;               // from the median step; 0 with fewer than two frames
};
[[nodiscard]] Recorded recorded_of(const std::vector<FrameSpan>& spans);

/// Closest distance of an actor's centre to the rig; `is_found` is false if they share no time.
struct Approach {
  bool is_found = false;
  double distance_m = 0.0, time_s = 0.0;
};
[[nodiscard]] Approach nearest_approach(const Actor& actor, const Trajectory& world_from_rig);

/// Numbers of pictures and sweeps of a log during the actor's track.
struct ActorFrames {
  std::size_t images = 0, sweeps = 0;
};
[[nodiscard]] ActorFrames frames_with(const Actor& actor, const Log& log);
/// Returns the known origins of a sensor's numbers, one line each.
[[nodiscard]] std::string origin_text(const std::string& source,
                                      const std::string& licence,
                                      const std::string& note);

}  // namespace simuli::cli

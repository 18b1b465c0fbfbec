#pragma once
// What a log, a scene or a sensor consists of, as text for people or as JSON with units in the key names.
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
/// The particles of a file that other programs read, too.
void print_splats(const std::filesystem::path& file, bool json);
void print_scene(const SceneFile& scene, bool json);
void print_sensor(const CameraFile& camera, bool json);
void print_sensor(const LidarFile& lidar, bool json);

/// All built-in sensors, one line each.
void print_sensor_names(const std::vector<std::string>& cameras,
                        const std::vector<std::string>& lidars,
                        bool json);

/// One line of a list of sensors, without its end.
[[nodiscard]] std::string lidar_line(const LidarModel& lidar);
[[nodiscard]] std::string camera_line(const Camera& camera);
/// The same for programs: no rows and no rays.
[[nodiscard]] nlohmann::ordered_json lidar_summary(const LidarModel& lidar);
[[nodiscard]] nlohmann::ordered_json camera_summary(const Camera& camera);

/// Of a set of particles, for programs and as one line for people.
[[nodiscard]] nlohmann::ordered_json set_json(const GaussianSet& set);
[[nodiscard]] std::string set_text(const char* name, const GaussianSet& set);

/// When a sensor recorded.
struct Recorded {
  std::size_t frames = 0;
  double start_s = 0.0, end_s = 0.0;  // of the first and the last frame; without frames 0
  double rate_hz = 0.0;               // of the median step; below two frames 0
};
[[nodiscard]] Recorded recorded_of(const std::vector<FrameSpan>& spans);

/// The nearest that an actor's centre comes to the rig; `is_met` is false where no time has both.
struct Approach {
  bool is_met = false;
  double distance_m = 0.0, time_s = 0.0;
};
[[nodiscard]] Approach nearest_approach(const Actor& actor, const Trajectory& world_from_rig);

/// Pictures and sweeps of a log while the actor is there.
struct ActorFrames {
  std::size_t images = 0, sweeps = 0;
};
[[nodiscard]] ActorFrames frames_with(const Actor& actor, const Log& log);
/// Where its numbers come from: a line each, of what is known.
[[nodiscard]] std::string origin_text(const std::string& source,
                                      const std::string& licence,
                                      const std::string& note);

}  // namespace simuli::cli

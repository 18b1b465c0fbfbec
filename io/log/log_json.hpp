#pragma once
// Sensors, poses and trajectories as JSON, shared by log.json and scene.json. Key names contain the units; times on disk
// are int64 nanoseconds. Readers throw Error{kInput} as described in io/base/json_reader.hpp and check values with
// validate().
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/core/base/error.hpp"
#include "io/base/json_reader.hpp"
#include "io/log/frame_spans.hpp"
#include "io/log/log.hpp"

namespace simuli {

/// {"position_m": [x, y, z], "rotation_wxyz": [w, x, y, z]}
[[nodiscard]] Json to_json(const Pose& a_from_b);
[[nodiscard]] Pose pose_from_json(JsonObject& object);

/// Model and mounting of one camera.
[[nodiscard]] Json to_json(const LogCamera& camera);
[[nodiscard]] LogCamera camera_from_json(JsonObject& object);

/// Model (every row in full) and mounting of one LiDAR.
[[nodiscard]] Json to_json(const LogLidar& lidar);
[[nodiscard]] LogLidar lidar_from_json(JsonObject& object);

/// The arrays "cameras" and "lidars" of an object; names are unique over both.
void add_sensors(Json& object, const std::vector<LogCamera>& cameras, const std::vector<LogLidar>& lidars);
void read_sensors(JsonObject& object, std::vector<LogCamera>& cameras, std::vector<LogLidar>& lidars);

/// [{"time_ns", "position_m", "rotation_wxyz"}, ...]; start_ns is added to the trajectory's seconds. A file
/// without an epoch of its own passes 0: nanoseconds since the start of the log.
[[nodiscard]] Json to_json(const Trajectory& world_from_rig, std::int64_t start_ns);
[[nodiscard]] Trajectory trajectory_from_json(JsonObject& parent,
                                              const std::string& key,
                                              std::int64_t start_ns);

/// [{"name", "kind", "length_m", "width_m", "height_m", "track": [{"time_ns", "position_m", "rotation_wxyz"},
/// ...]}, ...], times as those of a trajectory; key poses that training moved add "shift_m" and "turn_rad".
/// Names are unique.
[[nodiscard]] Json to_json(const std::vector<Actor>& actors, std::int64_t start_ns);
[[nodiscard]] std::vector<Actor> actors_from_json(JsonObject& parent,
                                                  const std::string& key,
                                                  std::int64_t start_ns);

/// {"time_start_ns", "time_end_ns"}, times as those of a trajectory; errors name `field`.
[[nodiscard]] Json to_json(const FrameSpan& span, std::int64_t start_ns, const std::string& field);
[[nodiscard]] FrameSpan frame_span_from_json(JsonObject& object, std::int64_t start_ns);
/// Throws Error{kInput} naming the first frame of the array `field` whose time_start_s is before that of its
/// predecessor.
template <class Frame>
void need_time_order(const std::vector<Frame>& frames, const std::string& file, const std::string& field) {
  for (std::size_t i = 1; i < frames.size(); ++i) {
    if (frames[i].time_start_s >= frames[i - 1].time_start_s) continue;
    throw_input_error(file,
                      field + '[' + std::to_string(i) + "].time_start_ns",
                      "a time before the frame above",
                      "frames in order of time");
  }
}

/// A whole log.json, whose file names are relative to `folder`.
[[nodiscard]] Json to_json(const Log& log);
[[nodiscard]] Log log_from_json(JsonObject& root, const std::filesystem::path& folder);

/// Convert seconds since start_ns to nanoseconds on disk and back. Error{kInput} naming `field` beyond 120 years.
[[nodiscard]] std::int64_t to_ns(double time_s, std::int64_t start_ns, const std::string& field);
[[nodiscard]] double read_time_s(JsonObject& object, const std::string& key, std::int64_t start_ns);
/// An absolute time: int64 nanoseconds, 1843 to 2096.
[[nodiscard]] std::int64_t read_time_ns(JsonObject& object, const std::string& key);

}  // namespace simuli

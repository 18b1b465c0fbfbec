#pragma once
// What a log, a scene or a sensor consists of, as text for people or as JSON with units in the key names.
#include <string>
#include <vector>

#include "io/log/log.hpp"
#include "io/log/sensor_file.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli::cli {

/// Prints to stdout.
void print_log(const Log& log, bool json);
void print_scene(const SceneFile& scene, bool json);
void print_sensor(const CameraFile& camera, bool json);
void print_sensor(const LidarFile& lidar, bool json);

/// The names of all built-in sensors, LiDARs with one line each.
void print_sensor_names(const std::vector<std::string>& cameras,
                        const std::vector<std::string>& lidars,
                        bool json);

/// One line of a list of sensors, without its end.
[[nodiscard]] std::string lidar_line(const LidarModel& lidar);
/// Where its numbers come from: a line each, of what is known.
[[nodiscard]] std::string origin_text(const std::string& source,
                                      const std::string& licence,
                                      const std::string& note);

}  // namespace simuli::cli

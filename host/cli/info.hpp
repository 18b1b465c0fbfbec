#pragma once
// What a log, a scene or a sensor consists of, as text for people or as JSON with units in the key names.
#include <string>
#include <vector>

#include "io/log/lidar_json.hpp"
#include "io/log/log.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli::cli {

/// Prints to stdout.
void print_log(const Log& log, bool json);
void print_scene(const SceneFile& scene, bool json);
void print_camera(const Camera& camera, bool json);
void print_lidar(const LidarFile& lidar, bool json);

/// The names of all built-in sensors, LiDARs with one line each.
void print_sensor_names(const std::vector<std::string>& cameras,
                        const std::vector<std::string>& lidars,
                        bool json);

/// One line of a list of sensors, without its end.
[[nodiscard]] std::string lidar_line(const LidarModel& lidar);

}  // namespace simuli::cli

#pragma once
// What a log, a scene or a sensor consists of, as text for people or as JSON with units in the key names.
#include <string>

#include "io/log.hpp"
#include "io/scene_folder.hpp"

namespace simuli::cli {

/// Prints to stdout.
void print_log(const Log& log, bool json);
void print_scene(const SceneFile& scene, bool json);
void print_camera(const Camera& camera, bool json);
void print_lidar(const Lidar& lidar, bool json);

}  // namespace simuli::cli

#pragma once
#include <filesystem>
#include <vector>

#include "host/scene/scene.hpp"
#include "io/log.hpp"

namespace simuli {

/// A scene with the sensors and the trajectory it was trained on, so that it renders without its log.
struct SceneFile {
  Scene scene;
  std::vector<LogCamera> cameras;
  std::vector<LogLidar> lidars;
  Trajectory world_from_rig;
};

/// Scene folder: camera.ply, lidar.ply, scene.json. Unknown keys are errors. Errors as in io/log.hpp.
[[nodiscard]] SceneFile read_scene(const std::filesystem::path& folder);
/// Writes each file atomically, scene.json last.
void write_scene(const std::filesystem::path& folder, const SceneFile& scene);

}  // namespace simuli

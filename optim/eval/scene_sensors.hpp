#pragma once
// Sensors of a log with the parameters that its scene has learned.
#include "io/log/log.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli {

/// Returns the log with mountings of sensors from the scene, by name; and for LiDARs the range limit, blind
/// arcs and range biases from the scene.
[[nodiscard]] Log with_sensors_of(const SceneFile& scene, Log log);

}  // namespace simuli

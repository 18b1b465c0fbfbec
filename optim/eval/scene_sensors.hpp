#pragma once
// What a scene knows better than its log: where sensors sit, and what they are.
#include "io/log/log.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli {

/// The log with those of its sensors that the scene has, by name, mounted as there; LiDARs with the range
/// limit, the blind arcs and the rows' range biases that the scene has found.
[[nodiscard]] Log with_sensors_of(const SceneFile& scene, Log log);

}  // namespace simuli

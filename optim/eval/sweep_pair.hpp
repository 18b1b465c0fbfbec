#pragma once
// A recorded sweep and the rendering of its rays.
#include <cstddef>

#include "host/device/render/scene/scene_on_device.hpp"
#include "io/log/log.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli {

/// Both have true distances, without range biases.
struct SweepPair {
  static constexpr double kSame_m = 0.3;
  RayResults simulated;
  Sweep recorded;
};
/// Whether the scene reproduces that recorded return within kSame_m of its distance.
[[nodiscard]] bool is_met(const SweepPair& pair, std::size_t ray);
/// Renders the rays of a recorded sweep. Throws Error{kInput} when the file cannot be read.
[[nodiscard]] SweepPair render_sweep(SceneOnDevice& scene, const Log& log, const SweepFrame& frame);

// Sensors of a log with the parameters that its scene has learned.

/// Returns the log with mountings of sensors from the scene, by name; and for LiDARs the range limit, blind
/// arcs and range biases from the scene.
[[nodiscard]] Log with_sensors_of(const SceneFile& scene, Log log);

}  // namespace simuli

#pragma once
// A recorded sweep beside what a scene says of its rays.
#include <cstddef>

#include "host/device/render/scene/scene_on_device.hpp"
#include "io/log/log.hpp"

namespace simuli {

/// Distances of both are true ones: without the biases of their rows.
struct SweepPair {
  static constexpr double kSame_m = 0.3;
  RayResults simulated;
  Sweep recorded;
};
/// Whether the scene has that recorded return, too, within kSame_m of its distance.
[[nodiscard]] bool is_met(const SweepPair& pair, std::size_t ray);
/// Renders the rays of a recorded sweep. Error{kInput} when it can't be read.
[[nodiscard]] SweepPair render_sweep(SceneOnDevice& scene, const Log& log, const SweepFrame& frame);

}  // namespace simuli

#pragma once
// A scene's particles as one set without actors, for formats without actors.
#include "host/core/scene/scene.hpp"

namespace simuli {

/// Returns the background without actors, including the inpainted sets.
[[nodiscard]] GaussianSet background_of(const Scene& scene, SetKind kind);

/// Returns the background, followed by the actors present at that time (seconds of the log) at their positions
/// then: m from Scene::origin.
[[nodiscard]] GaussianSet moment_of(const Scene& scene, SetKind kind, double time_s);

}  // namespace simuli

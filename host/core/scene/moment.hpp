#pragma once
// A scene's particles as one set without actors, for programs that know none.
#include "host/core/scene/scene.hpp"

namespace simuli {

/// The particles of the background without any actor, and what fills the places that are seen then.
[[nodiscard]] GaussianSet background_of(const Scene& scene, SetKind kind);

/// The background's particles, then those of the actors that are there at that time (seconds of the log),
/// where they are then: m from Scene::origin.
[[nodiscard]] GaussianSet moment_of(const Scene& scene, SetKind kind, double time_s);

}  // namespace simuli

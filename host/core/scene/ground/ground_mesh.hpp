#pragma once
#include "host/core/scene/ground/ground_map.hpp"
#include "host/core/scene/ground/triangle_mesh.hpp"
#include "host/core/scene/scene.hpp"
#include "host/core/sensors/trajectory.hpp"

namespace simuli {

/// The ground of a scene, m from Scene::origin: of the means of the LiDAR set's particles that stand still
/// and hide at least half of what is behind them.
[[nodiscard]] GroundMap ground_of(const Scene& scene);

/// Of that what hangs together with the path. Empty where nothing is known below the path.
[[nodiscard]] TriangleMesh ground_mesh(const GroundMap& ground,
                                       const Scene& scene,
                                       const Trajectory& world_from_rig);

}  // namespace simuli

#pragma once
#include "host/core/scene/ground/ground_map.hpp"
#include "host/core/scene/ground/triangle_mesh.hpp"
#include "host/core/scene/scene.hpp"
#include "host/core/sensors/trajectory.hpp"

namespace simuli {

/// Returns the ground of a scene, m from Scene::origin, from the means of static LiDAR particles with an
/// opacity of at least 1/2.
[[nodiscard]] GroundMap ground_of(const Scene& scene);

/// Returns the part connected to the path. Empty where no ground is known below the path.
[[nodiscard]] TriangleMesh ground_mesh(const GroundMap& ground,
                                       const Scene& scene,
                                       const Trajectory& world_from_rig);

}  // namespace simuli

#pragma once
#include "host/scene/ground/triangle_mesh.hpp"
#include "host/scene/scene.hpp"
#include "host/sensors/trajectory.hpp"

namespace simuli {

/// The ground around a scene's path, m from Scene::origin: GroundMap of the means of the LiDAR set's
/// particles that stand still and hide at least half of what is behind them, as far as it hangs together with
/// the path. Empty where no such particles lie below the path.
[[nodiscard]] TriangleMesh ground_mesh(const Scene& scene, const Trajectory& world_from_rig);

}  // namespace simuli

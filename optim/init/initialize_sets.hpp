#pragma once
// Conversion of points to particles, the last step of the initialisation.
#include <cstdint>
#include <vector>

#include "host/core/scene/gaussians.hpp"
#include "optim/init/initialize.hpp"
#include "optim/init/initialize_unseen.hpp"
#include "optim/init/initialize_views.hpp"
#include "optim/init/points/points.hpp"
#include "optim/init/points/surface_cells.hpp"

namespace simuli {

/// Makes a LiDAR particle on each of `cells` of `points`, which average returns in voxels of voxel_m.
[[nodiscard]] GaussianSet lidar_set(const PointSet& points,
                                    const std::vector<SurfaceCell>& cells,
                                    double voxel_m,
                                    const InitOptions& options);

/// Makes LiDAR particles of dark surfaces: rays that hit them drop.
[[nodiscard]] GaussianSet dark_set(const PointSet& points, const InitOptions& options);

/// Makes LiDAR particles that no training ray hits: opaque from the start, because they are not trained.
[[nodiscard]] GaussianSet unmet_set(const PointSet& points, const InitOptions& options);

/// Makes a camera particle on every point, coloured by `observations`.
[[nodiscard]] GaussianSet camera_set(const PointSet& points,
                                     const std::vector<PointObservation>& observations,
                                     const InitOptions& options);

/// Makes particles on the cells at the indices `kept`: opaque from the start, because no picture trains them.
[[nodiscard]] GaussianSet unseen_set(const UnseenSurfaces& surfaces,
                                     const std::vector<std::uint32_t>& kept,
                                     const InitOptions& options);

/// Returns the particles of unseen_set() in an initial camera set that are flat; leaves, which show through one
/// another, are not.
[[nodiscard]] std::vector<Eigen::Index> unseen_walls(const GaussianSet& start);

/// Makes camera particles of the shell's `patches` at the indices `kept`.
[[nodiscard]] GaussianSet shell_set(const FarShell& shell,
                                    const std::vector<FarShell::Patch>& patches,
                                    const std::vector<std::uint32_t>& kept,
                                    const InitOptions& options);

/// Appends `others` of the same kind and SH degree to `to`, as particles of `actor` (GaussianSet::actor).
void append(GaussianSet& to, const GaussianSet& others, std::uint32_t actor);

}  // namespace simuli

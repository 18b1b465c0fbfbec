#pragma once
// Particles from points: the last step of the initialisation.
#include <cstdint>
#include <vector>

#include "host/core/scene/gaussians.hpp"
#include "optim/init/initialize.hpp"
#include "optim/init/initialize_unseen.hpp"
#include "optim/init/initialize_views.hpp"
#include "optim/init/points/points.hpp"
#include "optim/init/points/surface_cells.hpp"

namespace simuli {

/// A LiDAR particle on each of `cells`, which are cells of `points`, returns averaged in voxels of voxel_m.
[[nodiscard]] GaussianSet lidar_set(const PointSet& points,
                                    const std::vector<SurfaceCell>& cells,
                                    double voxel_m,
                                    const InitOptions& options);

/// The same of what gives no light back: rays that meet it drop.
[[nodiscard]] GaussianSet dark_set(const PointSet& points, const InitOptions& options);

/// The same of what no ray has met: opaque from the start, since none teaches it.
[[nodiscard]] GaussianSet unmet_set(const PointSet& points, const InitOptions& options);

/// A camera particle on every point, coloured by `looks`.
[[nodiscard]] GaussianSet camera_set(const PointSet& points,
                                     const std::vector<PointObservation>& looks,
                                     const InitOptions& options);

/// One on each of the cells at the indices `kept`: opaque from the start, since no picture teaches it.
[[nodiscard]] GaussianSet unseen_set(const UnseenSurfaces& surfaces,
                                     const std::vector<std::uint32_t>& kept,
                                     const InitOptions& options);

/// Of a camera set as it was started those of unseen_set() that are flat: no leaves, which show through one another.
[[nodiscard]] std::vector<Eigen::Index> unseen_walls(const GaussianSet& start);

/// The shell's `patches` at the indices `kept` as camera particles.
[[nodiscard]] GaussianSet shell_set(const FarShell& shell,
                                    const std::vector<FarShell::Patch>& patches,
                                    const std::vector<std::uint32_t>& kept,
                                    const InitOptions& options);

/// Puts `others` of the same kind and SH degree behind `to`, as particles of `actor` (GaussianSet::actor).
void append(GaussianSet& to, const GaussianSet& others, std::uint32_t actor);

}  // namespace simuli

#pragma once
// Surfaces hit by LiDAR that no picture shows: occluded parts, and surfaces just outside the pictures. They
// become visible off the trajectory.
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "optim/init/init_options.hpp"
#include "optim/init/initialize_views.hpp"
#include "optim/init/points/points.hpp"
#include "optim/init/points/surface_cells.hpp"
#include "optim/init/points/surface_shapes.hpp"

namespace simuli {

/// Surfaces of points without observation that a view would show if it were moved by up to options.off_path_m
/// to either side or upwards. No picture trains them, so they are made closed like those of the LiDAR set.
struct UnseenSurfaces {
  std::vector<SurfaceCell> cells;
  std::vector<SurfaceShape> shapes;      // [cells]
  std::vector<Eigen::Vector3f> colours;  // [cells], of what pictures show nearby that faces, reflects and
                                         // lies high alike
  std::size_t points = 0;                // points that the cells represent
};

/// `observations`: [points], observations in the pictures of `views`. Empty when no point is observed, or off_path_m
/// is 0.
[[nodiscard]] UnseenSurfaces unseen_surfaces(const PointSet& points,
                                             const std::vector<PointObservation>& observations,
                                             const std::vector<ImageView>& views,
                                             const InitOptions& options);

}  // namespace simuli

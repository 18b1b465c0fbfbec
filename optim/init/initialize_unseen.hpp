#pragma once
// What the laser met and no picture shows: the far side of what stood before it, and what lies just outside
// the pictures. It comes into sight when a camera leaves the recorded path.
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "optim/init/init_options.hpp"
#include "optim/init/initialize_views.hpp"
#include "optim/init/points/points.hpp"
#include "optim/init/points/surface_cells.hpp"
#include "optim/init/points/surface_shapes.hpp"

namespace simuli {

/// The surfaces of points without a look that one of the views would have in its picture were it up to
/// options.off_path_m to either side, or above. No picture will ever repair them: they are made closed, as the
/// LiDAR set's are.
struct UnseenSurfaces {
  std::vector<SurfaceCell> cells;
  std::vector<SurfaceShape> shapes;      // [cells]
  std::vector<Eigen::Vector3f> colours;  // [cells], of what pictures show nearby that faces, reflects and
                                         // lies high alike
  std::size_t points = 0;                // that the cells stand for
};

/// `looks`: [points], by the pictures of `views`. Nothing when no point has a look, or off_path_m is 0.
[[nodiscard]] UnseenSurfaces unseen_surfaces(const PointSet& points,
                                             const std::vector<PointObservation>& looks,
                                             const std::vector<ImageView>& views,
                                             const InitOptions& options);

}  // namespace simuli

#pragma once
// How wide a particle must be for a set of them to close a surface, along each of its own axes.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "optim/init/points/surface_cells.hpp"

namespace simuli {

/// Least standard deviation of a first particle along a surface: a third of a voxel. Not measured.
inline constexpr double kLeastScale_m = 0.03;
/// Standard deviation of a LiDAR particle over the distance to the next one along the same axis. Drive 0052:
/// 0.7 4.90 cm, 0.5 4.34 cm; 0013: 0.4 3.87 cm of 3.94 with 2 % more particles; street: 0.45 0.31 cm of 0.27.
inline constexpr double kLidarScale = 0.5;

struct ShapeOptions {
  double voxel_m = 0.1;        // of the points
  double scale = kLidarScale;  // standard deviation over the distance to the next particle
  double min_m = kLeastScale_m;
  double max_m = 0.5;
  double thin_m = 0.01;  // least one across it; 3 and 5 mm came to the same error (street, drive 0013)
};

struct SurfaceShape {
  Eigen::Quaternionf scene_from_local = Eigen::Quaternionf::Identity();
  Eigen::Vector3f scale_m =
      Eigen::Vector3f::Zero();  // standard deviations; of a plane the third is across it
  bool planar = false;
};

/// A shape for each of the `cells` of `points`. On a plane its axes are those of the sensor's own sampling,
/// along which rows and columns of returns lie: each reaches as far as the cell does, or half-way to the next
/// one on either side where the sensor left a gap, but no farther than a single sweep would leave one. What
/// is no plane is as wide as its cell, or as its neighbours are near.
[[nodiscard]] std::vector<SurfaceShape> surface_shapes(const PointSet& points,
                                                       const std::vector<SurfaceCell>& cells,
                                                       const ShapeOptions& options);

}  // namespace simuli

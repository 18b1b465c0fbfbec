#pragma once
// How wide a particle must be for a set of them to close a surface, along each of its own axes.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "optim/points/surface_cells.hpp"

namespace simuli {

struct ShapeOptions {
  double voxel_m = 0.1;  // of the points
  double scale = 0.5;    // standard deviation over the distance to the next particle along the same axis
  double min_m = 0.03;   // of standard deviations along a surface
  double max_m = 0.5;
  double thin_m = 0.01;  // least one across it
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

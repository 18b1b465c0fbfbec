#pragma once
// Sizes of particles along their own axes such that a set of them closes a surface.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "optim/init/points/surface_cells.hpp"

namespace simuli {

/// Smallest standard deviation along a surface: a third of a voxel.
inline constexpr double kLeastScale_m = 0.03;
/// Standard deviation of a LiDAR particle relative to the distance to the next one along the same axis
/// (docs/DECISIONS.md, "LiDAR set").
inline constexpr double kLidarScale = 0.5;

struct ShapeOptions {
  double voxel_m = 0.1;  // of the points
  double scale = kLidarScale;  // standard deviation relative to the distance to the next particle
  double min_m = kLeastScale_m;
  double max_m = 0.5;
  double thin_m = 0.01;  // smallest standard deviation across the surface
};

struct SurfaceShape {
  Eigen::Quaternionf scene_from_local = Eigen::Quaternionf::Identity();
  Eigen::Vector3f scale_m =
      Eigen::Vector3f::Zero();  // standard deviations; on a plane the third is across it
  bool planar = false;
};

/// Returns a shape for each of the `cells` of `points`. On a plane its axes are the sensor's sampling
/// directions, along rows and columns of returns: each extends as far as the cell, or half-way to the next cell
/// on either side, limited by the spacing of a single sweep. Other cells are as wide as the cell or the
/// distance to their neighbours.
[[nodiscard]] std::vector<SurfaceShape> surface_shapes(const PointSet& points,
                                                       const std::vector<SurfaceCell>& cells,
                                                       const ShapeOptions& options);

}  // namespace simuli

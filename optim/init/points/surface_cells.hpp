#pragma once
// Represents points by few surface cells: voxels grow with the observation distance, and flat neighbours of
// similar intensity are merged.
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "optim/init/points/points.hpp"

namespace simuli {

struct CellOptions {
  double voxel_m = 0.1;  // of the points, and of the smallest cell
  double voxel_rad = 0.0;  // largest side of a cell relative to its smallest observation range; 0: no growth
  double flat_side_m = 0.0;  // largest side of flat cells; 0: none
  double flat_m = 0.0;  // largest standard deviation from their plane
  double alike = 0.0;  // largest standard deviation of intensity
};

/// Options of the LiDAR set's cells (docs/DECISIONS.md, "LiDAR set"). flat_m is the range noise of a spinning
/// LiDAR, alike the error of trained intensities.
inline constexpr CellOptions kLidarCells{
    .voxel_rad = 0.01, .flat_side_m = 0.8, .flat_m = 0.015, .alike = 0.1};

/// Merged points.
struct SurfaceCell {
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();
  Eigen::Matrix3f covariance = Eigen::Matrix3f::Zero();  // m^2, of the points about the mean
  float intensity = 0.0F;
  float side_m = 0.0F;
  std::uint32_t points = 0;
  Sight sight;  // the nearest sight
};

/// Returns cells of an octree over the points' voxels, with sides that are powers of two of a voxel, along its
/// Morton curve: the largest that no sensor observed from nearer than side / voxel_rad, or that are flat, of
/// similar intensity, and covered with points as densely as the sensor covers a surface there. Each point
/// belongs to one cell; a cell with neither property has a single point. Independent of the order of points.
[[nodiscard]] std::vector<SurfaceCell> surface_cells(const PointSet& points, const CellOptions& options);

}  // namespace simuli

#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/scene/gaussians.hpp"

namespace simuli {

/// Reads a set of Gaussians from a PLY: the standard 3DGS layout (x y z, f_dc_*, f_rest_* channel-major,
/// opacity logit, scale_* log, rot_* w x y z), ascii or binary either endian, properties by name in any
/// order and type, normals and unknown properties ignored, SH degree from the count of f_rest.
/// A LiDAR set uses the same names. Error{kInput} (file, property, vertex, found, allowed) for counts
/// that the file's size can't hold, NaN or Inf, list properties, missing properties.
[[nodiscard]] GaussianSet read_gaussians_ply(const std::filesystem::path& file, SetKind kind);
/// Binary little endian, the standard 3DGS property order (x y z nx ny nz f_dc f_rest opacity scale rot).
void write_gaussians_ply(const std::filesystem::path& file, const GaussianSet& set);

/// A point cloud: x y z (m), intensity in [0,1], and whatever extra named float columns are given.
struct PointCloud {
  std::vector<std::string> columns;  // at least "x","y","z"
  Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> values;  // [N, columns]
};
void write_point_cloud_ply(const std::filesystem::path& file, const PointCloud& cloud);

}  // namespace simuli

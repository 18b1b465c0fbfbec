#pragma once
// Point clouds for other programs.
#include <filesystem>

#include "io/splat/ply.hpp"

namespace simuli {

/// By extension: .ply (io/splat/ply.hpp); .pcd (PCL's format 0.7, binary); .npz (NumPy: "xyz" [N, 3] and an
/// array [N] per further column), each column in its type, rounded to it. Error{kInput} for other extensions,
/// and as write_point_cloud_ply.
void write_point_cloud(const std::filesystem::path& file, const PointCloud& cloud);

}  // namespace simuli

#pragma once
// Point clouds in formats of other programs.
#include <filesystem>

#include "io/splat/ply.hpp"

namespace simuli {

/// The extension selects the format: .ply (io/splat/ply.hpp); .pcd (PCL's format 0.7, binary); .npz (NumPy:
/// "xyz" [N, 3] and an array [N] per further column), each column rounded to its type. Throws Error{kInput} for
/// other extensions; errors as in write_point_cloud_ply().
void write_point_cloud(const std::filesystem::path& file, const PointCloud& cloud);

}  // namespace simuli

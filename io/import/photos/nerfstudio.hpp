#pragma once
#include <filesystem>

#include "io/import/photos/photo_log.hpp"

namespace simuli {

struct NerfstudioOptions {
  std::filesystem::path transforms;  // transforms.json, or its folder
  std::filesystem::path output;
  double metres_per_unit = 0.0;  // 0: see write_photo_log()
};

/// Reads posed photographs in the format of nerfstudio and instant-ngp: intrinsics per frame or for all frames,
/// OpenGL camera axes, +z up; points of "ply_file_path" if present. Throws Error{kInput} naming file and field
/// for missing data and for camera models other than pinholes, OPENCV and OPENCV_FISHEYE.
[[nodiscard]] PhotoSet read_nerfstudio(const NerfstudioOptions& options);
/// Imports them as write_photo_log() does.
Log import_nerfstudio(const NerfstudioOptions& options, const FrameProgress& progress, PhotoReport& report);

}  // namespace simuli

#pragma once
#include <filesystem>

#include "io/import/photos/photo_log.hpp"

namespace simuli {

struct NerfstudioOptions {
  std::filesystem::path transforms;  // transforms.json, or the folder that holds it
  std::filesystem::path output;
  double metres_per_unit = 0.0;  // 0: see write_photo_log()
};

/// Posed photographs as nerfstudio and instant-ngp describe them: intrinsics for all frames or for
/// each, camera axes of OpenGL, +z up; the points of "ply_file_path" where there are some. Error{kInput}
/// naming file and field for anything missing and for camera models other than pinholes, OPENCV and
/// OPENCV_FISHEYE.
[[nodiscard]] PhotoSet read_nerfstudio(const NerfstudioOptions& options);
/// Imports them as write_photo_log() says.
Log import_nerfstudio(const NerfstudioOptions& options,
                      const FrameProgress& progress,
                      PhotoReport& report);

}  // namespace simuli

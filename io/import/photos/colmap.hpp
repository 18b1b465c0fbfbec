#pragma once
#include <filesystem>

#include "io/import/photos/photo_log.hpp"

namespace simuli {

struct ColmapOptions {
  std::filesystem::path
      model;  // folder of cameras, images and points3D, .bin or .txt; or a parent of sparse/0
  std::filesystem::path images;  // folder of the photographs; empty: "images" beside the model or in a parent
  std::filesystem::path output;
  double metres_per_unit = 0.0;  // 0: see write_photo_log()
};

/// Reads a COLMAP model: cameras SIMPLE_PINHOLE to FULL_OPENCV, OPENCV_FISHEYE and its simpler variants; poses
/// by name; points seen by at least three photographs, or all points if none has a track. The world is rotated
/// such that +z is up on average. Throws Error{kInput} naming file and field for missing or truncated data, and
/// for unsupported camera models.
[[nodiscard]] PhotoSet read_colmap(const ColmapOptions& options);
/// Imports the model with its photographs as write_photo_log() does.
Log import_colmap(const ColmapOptions& options, const FrameProgress& progress, PhotoReport& report);

}  // namespace simuli

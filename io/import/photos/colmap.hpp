#pragma once
#include <filesystem>

#include "io/import/photos/photo_log.hpp"

namespace simuli {

struct ColmapOptions {
  std::filesystem::path model;  // folder of cameras, images and points3D, .bin or .txt; or one above sparse/0
  std::filesystem::path images;  // folder of the photographs; empty: "images" beside the model or above it
  std::filesystem::path output;
  double metres_per_unit = 0.0;  // 0: see write_photo_log()
};

/// A COLMAP model: cameras SIMPLE_PINHOLE to FULL_OPENCV, OPENCV_FISHEYE and its simpler kinds; poses
/// by name; points seen by at least three photographs, or all where none has a track. The world is turned so
/// that +z is up on average. Error{kInput} naming file and field for anything missing, truncated, or a camera of another model.
[[nodiscard]] PhotoSet read_colmap(const ColmapOptions& options);
/// Imports it with its photographs as write_photo_log() says.
Log import_colmap(const ColmapOptions& options,
                  const FrameProgress& progress,
                  PhotoReport& report);

}  // namespace simuli

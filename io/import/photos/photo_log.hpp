#pragma once
// Logs of posed photographs: no LiDAR, no clock, and an independent pose per picture. For importers of
// structure from motion (io/import/photos/colmap.cpp, io/import/photos/nerfstudio.cpp).
#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "io/log/log.hpp"

namespace simuli {

struct Photo {
  std::filesystem::path file;
  std::size_t camera = 0;  // index in PhotoSet::cameras
  Pose world_from_camera;  // in the source's unit
};

struct PhotoSet {
  std::string source;  // file with the poses, for messages
  std::vector<Camera> cameras;
  std::vector<Photo> photos;            // ordered such that neighbours overlap
  std::vector<Eigen::Vector3d> points;  // seen by several photographs; may be empty
  std::vector<std::string> notes;       // parts left out, one per line
  bool level = false;                   // rotate the world such that the photographs' mean up direction is +z
};

struct PhotoReport {
  std::size_t photos = 0;
  std::size_t absent = 0;  // listed by the source, but missing
  std::size_t points = 0;
  double metres_per_unit = 1.0;
  std::vector<std::string> notes;  // parts left out or scaled, one per line
};

/// Whether a sorts before b with digits compared as numbers: 2.png before 10.png.
[[nodiscard]] bool is_before(const std::string& a, const std::string& b);

/// Writes the log folder atomically: photograph i is taken at i seconds by a rig at its camera's pose.
/// `metres_per_unit` 0: scaled such that points are typically 10 m from the nearest photographs, or, without
/// points, such that neighbouring photographs are typically 0.5 m apart, which initialisation and training
/// expect. Missing photographs are left out and counted; of photographs listed twice the first is used; a
/// camera whose photographs are smaller (images_2 ..) is scaled. Throws Error{kInput} for a photograph whose
/// aspect differs from its camera's, and if none is left.
Log write_photo_log(PhotoSet set,
                    double metres_per_unit,
                    const std::filesystem::path& output,
                    const FrameProgress& progress,
                    PhotoReport& report);

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

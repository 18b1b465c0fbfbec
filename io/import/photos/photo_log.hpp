#pragma once
// Logs of posed photographs: no LiDAR, no clock, every picture from a place of its own. For importers of
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
  std::size_t camera = 0;  // of PhotoSet::cameras
  Pose world_from_camera;  // in units of the source
};

struct PhotoSet {
  std::string source;  // the file that tells of them, for messages
  std::vector<Camera> cameras;
  std::vector<Photo> photos;            // in an order in which neighbours see the same things
  std::vector<Eigen::Vector3d> points;  // seen by several photographs; may be empty
  std::vector<std::string> notes;       // what was left out, a line each
  bool level = false;                   // turn the world so that the photographs' mean "up" is +z
};

struct PhotoReport {
  std::size_t photos = 0;
  std::size_t absent = 0;  // named by the source, but not there
  std::size_t points = 0;
  double metres_per_unit = 1.0;
  std::vector<std::string> notes;  // what was left out or scaled, a line each
};

/// Whether a comes before b when runs of digits count as numbers: 2.png before 10.png.
[[nodiscard]] bool is_before(const std::string& a, const std::string& b);

/// Writes the log folder, complete or not at all: photograph i is taken at i seconds by a rig that stands
/// where its camera does. `metres_per_unit` 0: so that points are typically 10 m from the photographs that
/// stand nearest to them, or without points that neighbouring photographs are typically 0.5 m apart, which is
/// what initialisation and training expect of a scene. Photographs that are not there are left out and
/// counted, of those named twice the first is taken, and a camera whose photographs are smaller (images_2 ..)
/// becomes as small. Error{kInput} for one of another shape than its camera's, or when none is left.
Log write_photo_log(PhotoSet set,
                    double metres_per_unit,
                    const std::filesystem::path& output,
                    const FrameProgress& progress,
                    PhotoReport& report);

}  // namespace simuli

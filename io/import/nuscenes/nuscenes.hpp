#pragma once
#include <cstddef>
#include <filesystem>
#include <string>

#include "io/log/label_tracks.hpp"
#include "io/log/log.hpp"

namespace simuli {

struct NuscenesOptions {
  /// Folder of the data set, with the tables in `version`; the tables contain relative file names.
  std::filesystem::path root;
  std::string version;  // "v1.0-mini"; empty: the existing one
  std::string scene;    // "scene-0061"; empty: the only one
  std::filesystem::path output;
};

struct NuscenesReport {
  std::size_t absent = 0;    // pictures and sweeps in the tables without files
  std::size_t rays = 0;      // of all firing grids
  std::size_t returned = 0;  // of these
  LabelReport labels;
  std::vector<std::string> hidden;  // cameras that show the ego vehicle, which their masks hide
};

/// Imports one scene of nuScenes: all cameras (rectified pinholes; 12 Hz), LIDAR_TOP (HDL-32E; 20 Hz), boxes.
/// The rig's frame is the ego frame, and the trajectory consists of the ego poses of all pictures and sweeps.
/// The files of LIDAR_TOP contain all firings of 32 beams each, the lowest first; returns closer than 1 m mean
/// no return. A sweep's time stamp and the frame of its points are those of its end; points are transformed
/// back to their time of measurement. Missing pictures and sweeps (subsets with key frames only) are left out
/// and counted. Throws Error{kInput} naming table, entry and field for inconsistent data.
Log import_nuscenes(const NuscenesOptions& options, const FrameProgress& progress, NuscenesReport& report);

}  // namespace simuli

#pragma once
#include <cstddef>
#include <filesystem>
#include <string>

#include "io/log/label_tracks.hpp"
#include "io/log/log.hpp"

namespace simuli {

struct NuscenesOptions {
  /// Folder of the data set: the tables below it in `version`, files as the tables name them.
  std::filesystem::path root;
  std::string version;  // "v1.0-mini"; empty: the one that is there
  std::string scene;    // "scene-0061"; empty: the only one
  std::filesystem::path output;
};

struct NuscenesReport {
  std::size_t absent = 0;           // pictures and sweeps that the tables name and that are not there
  std::size_t rays = 0;             // of all firing grids
  std::size_t returned = 0;         // of these
  LabelReport labels;
  std::vector<std::string> hidden;  // cameras that see the vehicle, whose masks hide it
};

/// Imports one scene of nuScenes: all cameras (rectified pinholes; 12 Hz), LIDAR_TOP (HDL-32E; 20 Hz), boxes.
/// The rig is the ego frame, the path its poses at the times of all pictures and sweeps. The files of
/// LIDAR_TOP list all firings, 32 beams each, lowest first; returns nearer than 1 m stand for none. A sweep's
/// time is that of its end, and so is the frame of its points: each is put back to where it was measured.
/// Pictures and sweeps that are not there (who has key frames alone) are left out and counted. Error{kInput}
/// naming table, entry and field for anything that does not fit together.
Log import_nuscenes(const NuscenesOptions& options,
                    const FrameProgress& progress,
                    NuscenesReport& report);

}  // namespace simuli

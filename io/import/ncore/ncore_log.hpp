#pragma once
// Import of drives in NCore, NVIDIA's format (version 4), as written by its converters for the Waymo Open
// Dataset, nuScenes, PhysicalAI-AV and others, and by export_ncore().
#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "host/core/sensors/lidar.hpp"
#include "io/import/points/point_grid.hpp"
#include "io/log/label_tracks.hpp"
#include "io/log/log.hpp"

namespace simuli {

struct NcoreOptions {
  /// A .zarr folder, a .zarr.itar, a folder of several of them of one sequence, or the .json that lists them.
  std::filesystem::path sequence;
  std::filesystem::path output;
  std::vector<std::string> cameras, lidars;  // empty: all
  std::map<std::string, Lidar> tables;       // tables of LiDARs by name, which replace the file's
  std::string rig_frame = "rig", world_frame = "world";
};

struct NcoreReport {
  PointReport points;                  // of LiDARs with tables
  std::size_t rays = 0, returned = 0;  // of all sweeps
  std::size_t twice = 0;               // rays with an element that another ray has; left out
  std::size_t echoes = 0;              // further returns of a ray; left out
  std::size_t unposed = 0;             // frames and boxes outside the trajectory; left out
  LabelReport labels;
  std::vector<std::string> notes;  // interpretation of the data, and parts left out
};

/// Throws Error{kInput} naming store, group and field for damaged or unsupported data, and for a sequence
/// without a trajectory of the rig. Throws Error{kUsage} for options of unknown sensors.
Log import_ncore(const NcoreOptions& options, const FrameProgress& progress, NcoreReport& report);

}  // namespace simuli

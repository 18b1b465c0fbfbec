#pragma once
// Drives in NCore, NVIDIA's format (version 4): what its converters make of the Waymo Open Dataset, nuScenes,
// PhysicalAI-AV and others, and what export_ncore() writes.
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
  /// A .zarr folder, a .zarr.itar, a folder of several of one sequence, or the .json that lists them.
  std::filesystem::path sequence;
  std::filesystem::path output;
  std::vector<std::string> cameras, lidars;  // of all these; empty: all
  std::map<std::string, Lidar> tables;       // of LiDARs by name, instead of the file's
  std::string rig_frame = "rig", world_frame = "world";
};

struct NcoreReport {
  PointReport points;                  // of LiDARs whose rays are placed by tables
  std::size_t rays = 0, returned = 0;  // of all sweeps
  std::size_t twice = 0;               // rays that name an element that another one has; left out
  std::size_t echoes = 0;              // further returns of a ray; left out
  std::size_t unposed = 0;             // frames and boxes beside the path; left out
  LabelReport labels;
  std::vector<std::string> notes;      // what was taken for what, and what was left out
};

/// Error{kInput} naming store, group and field for what is damaged or can't be read, and for a sequence
/// without a path of the rig. Error{kUsage} for options of sensors that it has not.
Log import_ncore(const NcoreOptions& options,
                 const FrameProgress& progress,
                 NcoreReport& report);

}  // namespace simuli

#pragma once
// Import of drives from other sources: sensors, trajectory and boxes as in log.json, sweeps as lists of points.
//
// The folder contains points.json: a log.json (io/log/log_json.hpp) except for
//   "format": "simuli points", "version": 1,
//   "point_columns": ["x_m", "y_m", "z_m", "intensity", "row", "time_s"],
//   "points_in": "sensor" or "world",
//   "lidars": [{"table": "hesai_pandar64", "name": "top", "rig_from_lidar": {...}}, ...],
//   "sweeps": [{"lidar": "top", "file": "points/000000.bin", "time_start_ns": .., "time_end_ns": ..}, ...]
//
// A sweep's file is little-endian float32 with the columns of each point: x_m, y_m and z_m, which are required;
// intensity, 0 to 1; row, the index of the table's beam, 0 is the highest; time_s after the sweep's start; other
// columns are ignored. Without rows a point belongs to the beam nearest in elevation, without times it has the time
// at which its column fires. Points in the sensor's frame are as measured, each at its own time; points in world
// coordinates need times, because the direction at a sweep's seam occurs at both ends. A LiDAR is a complete model
// as in log.json, or a built-in table by name (`simuli info sensors`), of which "columns", "azimuth_first_rad" and
// "spin" may be replaced. A common elevation offset of this unit's beams, the firing pattern of the beams and,
// without "columns", their number are estimated from the points.
#include <cstddef>
#include <filesystem>

#include "io/import/points/point_grid.hpp"

namespace simuli {

struct PointsOptions {
  std::filesystem::path folder;  // contains points.json
  std::filesystem::path output;
};

/// Imports such a folder: assigns each sweep to the firing grid of its LiDAR (io/import/points/point_grid.hpp) and
/// copies the pictures. Throws Error{kInput} naming file and field for inconsistent data, and if more than 5 % of all
/// points are left out, which indicates a wrong table.
Log import_points(const PointsOptions& options, const FrameProgress& progress, PointReport& report);

}  // namespace simuli

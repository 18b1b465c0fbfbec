#pragma once
// A drive of any other origin: sensors, path and boxes as in log.json, sweeps as bare lists of points.
//
// The folder holds points.json: a log.json (io/log/log_json.hpp) but for
//   "format": "simuli points", "version": 1,
//   "point_columns": ["x_m", "y_m", "z_m", "intensity", "row", "time_s"],
//   "points_in": "sensor" or "world",
//   "lidars": [{"table": "hesai_pandar64", "name": "top", "rig_from_lidar": {...}}, ...],
//   "sweeps": [{"lidar": "top", "file": "points/000000.bin", "time_start_ns": .., "time_end_ns": ..}, ...]
//
// A sweep's file is little endian float32, the columns of a point one after the other: x_m, y_m and z_m,
// which must be there; intensity, 0 to 1; row, the beam's of the table, 0 the highest; time_s after the
// sweep's start; any other name is skipped. Without rows a point belongs to the beam of the nearest
// elevation, without times to the time at which its column fires. In the sensor's frame points are as
// measured, each when it was measured; in the world they are where they were and need their times: what is
// seen at a sweep's seam may have been measured at either end. A LiDAR is a whole model as in log.json, or a
// built-in table by name (`simuli info sensors`), in which "columns", "azimuth_first_rad" and "spin" may be others. An
// angle that all beams of this unit are off by, which rows fire in which columns and, without "columns", how many there
// are is found in the points.
#include <cstddef>
#include <filesystem>

#include "io/import/points/point_grid.hpp"

namespace simuli {

struct PointsOptions {
  std::filesystem::path folder;  // with points.json
  std::filesystem::path output;
};

/// Imports such a folder: each sweep on the firing grid of its LiDAR (io/import/points/point_grid.hpp), pictures copied.
/// Error{kInput} naming file and field for what does not fit, and for more than 5 % of all points unplaced:
/// another sensor than the table says.
Log import_points(const PointsOptions& options,
                  const FrameProgress& progress,
                  PointReport& report);

}  // namespace simuli

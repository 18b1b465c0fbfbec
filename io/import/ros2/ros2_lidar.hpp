#pragma once
// Matching of a LiDAR's table with a recording's points: beams of rings, begin of a revolution, begin of a
// sweep. For io/import/ros2/*.cpp and tests.
#include <cstddef>
#include <string>
#include <vector>

#include "host/core/base/pose.hpp"
#include "host/core/sensors/lidar.hpp"
#include "io/import/points/point_grid.hpp"
#include "io/import/ros2/cloud_fields.hpp"
#include "io/import/ros2/ros2_log.hpp"

namespace simuli::ros2 {

/// Instant of a sweep that a stamp refers to.
enum class Stamp { kStart, kEnd, kUnknown };

struct RecordedLidar {
  Lidar model;              // as given, except for the begin and direction of a revolution
  std::vector<int> row_of;  // by ring; -1: none. Empty: beams by elevation
  double start_after_stamp_s = 0.0;
  Pose table_from_cloud;           // of points as in messages
  std::vector<std::string> notes;  // findings
};

/// Fits points of some sweeps in the table's frame; messages are `apart_s` apart (0: unknown). Rings are
/// assigned to beams by the elevation of their points, in any order. Throws Error{kInput} naming `file` and
/// `where` for rings on no beam, or two on one; the errors of find_turn(); and, for points without times, a
/// stamp of kUnknown.
[[nodiscard]] RecordedLidar fit_recorded(const Ros2Lidar& requested,
                                         const std::vector<std::vector<CloudPoint>>& sweeps,
                                         double apart_s,
                                         Stamp stamp,
                                         const std::string& file,
                                         const std::string& where);

/// Returns a sweep's points for grid_points(). Throws Error{kInput} for a ring that the sweeps of
/// fit_recorded() did not contain.
[[nodiscard]] std::vector<MeasuredPoint> measured(const std::vector<CloudPoint>& points,
                                                  const RecordedLidar& lidar,
                                                  const std::string& file,
                                                  const std::string& where);

}  // namespace simuli::ros2

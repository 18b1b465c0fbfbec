#pragma once
// A LiDAR's table beside the points of a recording: which ring is which row, where a turn begins, when a
// sweep does. For io/import/ros2/*.cpp and tests.
#include <cstddef>
#include <string>
#include <vector>

#include "host/core/base/pose.hpp"
#include "host/core/sensors/lidar.hpp"
#include "io/import/points/point_grid.hpp"
#include "io/import/ros2/cloud_fields.hpp"
#include "io/import/ros2/ros2_log.hpp"

namespace simuli::ros2 {

/// What a stamp means in a turn.
enum class Stamp { kStart, kEnd, kUnknown };

struct RecordedLidar {
  Lidar model;              // as given, but for where its turn begins and to which side it goes
  std::vector<int> row_of;  // by ring; -1: none. Empty: rows by elevation
  double start_after_stamp_s = 0.0;
  Pose table_from_cloud;           // of points as they are in messages
  std::vector<std::string> notes;  // what was found in the points
};

/// From the points of some sweeps, in the table's frame, of messages that are `apart_s` from each other (0: not
/// known). Rings are rows by where their points are: any order. Error{kInput} naming `file` and `where` for rings
/// that lie on no row, or two on one; what find_turn() refuses; and, where points have no times, a stamp that is
/// kUnknown.
[[nodiscard]] RecordedLidar fit_recorded(const Ros2Lidar& asked,
                                         const std::vector<std::vector<CloudPoint>>& sweeps,
                                         double apart_s,
                                         Stamp stamp,
                                         const std::string& file,
                                         const std::string& where);

/// Points of a sweep for grid_points(). Error{kInput} for a ring that none of fit_recorded()'s sweeps had.
[[nodiscard]] std::vector<MeasuredPoint> measured(const std::vector<CloudPoint>& points,
                                                  const RecordedLidar& lidar,
                                                  const std::string& file,
                                                  const std::string& where);

}  // namespace simuli::ros2

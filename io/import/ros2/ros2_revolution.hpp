#pragma once
// Rotation and firing rate of a recorded LiDAR: from the points' times and azimuths, else from the distance of
// messages (which may be lost) and the table's modes. For io/import/ros2/*.cpp.
#include <string>
#include <vector>

#include "host/core/sensors/lidar.hpp"
#include "io/import/points/firing_steps.hpp"
#include "io/import/ros2/cloud_fields.hpp"
#include "io/import/ros2/ros2_log.hpp"

namespace simuli::ros2 {

struct RecordedRevolution {
  Lidar model;                     // the table with the rate and columns found
  std::vector<std::string> notes;  // differences from the table
  std::vector<FiredRun> runs;      // azimuths of each beam, by sweep and beam
};

/// Analyses points of some sweeps in the table's frame, on the beams that `row_of` assigns to their rings
/// (empty: the nearest beams). `apart_s`: distance of messages; 0: unknown. Throws Error{kInput} naming `file`
/// and `where` for times that fit no revolution, and for a rate or columns other than the requested mode's.
[[nodiscard]] RecordedRevolution find_turn(const Ros2Lidar& requested,
                                           const std::vector<std::vector<CloudPoint>>& sweeps,
                                           const std::vector<int>& row_of,
                                           double apart_s,
                                           const std::string& file,
                                           const std::string& where);

}  // namespace simuli::ros2

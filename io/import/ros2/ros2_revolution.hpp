#pragma once
// How fast a recorded LiDAR turns and how often it fires in a turn: what points' times and azimuths say, before how far
// messages are apart (every second may be lost) and what the table's name leaves open. For io/import/ros2/*.cpp.
#include <string>
#include <vector>

#include "host/core/sensors/lidar.hpp"
#include "io/import/points/firing_steps.hpp"
#include "io/import/ros2/cloud_fields.hpp"
#include "io/import/ros2/ros2_log.hpp"

namespace simuli::ros2 {

struct RecordedRevolution {
  Lidar model;                     // the table at the rate and with the columns that were found
  std::vector<std::string> notes;  // where these are others than the table's
  std::vector<FiredRun> runs;      // what each row measured, by sweep and row
};

/// Of the points of some sweeps, in the table's frame, on the rows that `row_of` gives their rings (empty: on the
/// nearest). `apart_s`: between messages; 0: not known. Error{kInput} naming `file` and `where` for times that fit no
/// turn, and for another turn or other columns than the mode that was asked for has.
[[nodiscard]] RecordedRevolution find_turn(const Ros2Lidar& asked,
                                     const std::vector<std::vector<CloudPoint>>& sweeps,
                                     const std::vector<int>& row_of,
                                     double apart_s,
                                     const std::string& file,
                                     const std::string& where);

}  // namespace simuli::ros2

#pragma once
// Which way the LiDAR turns: sweeps of a moving sensor are crooked, and only one way of putting each point
// where it was at its time makes walls flat again.
#include <optional>
#include <string>
#include <vector>

#include "host/core/sensors/lidar.hpp"
#include "optim/calibration/path/odometry.hpp"

namespace simuli::calibration {

struct SpinReport {
  std::optional<SpinDirection> spin;
  double clockwise_m = 0.0;          // median distance of points from planes; infinity: no path was found
  double counter_clockwise_m = 0.0;  // under either direction
  std::string reason;                // where there is no answer
};

/// The same sweeps with times for either direction; ten or so are enough.
[[nodiscard]] SpinReport find_spin(const std::vector<Returns>& clockwise,
                                   const std::vector<Returns>& counter_clockwise,
                                   const OdometryOptions& options = {});

}  // namespace simuli::calibration

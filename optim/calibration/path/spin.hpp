#pragma once
// Finds the spin direction of a LiDAR: sweeps of a moving sensor are distorted, and only the right firing order
// makes walls flat.
#include <optional>
#include <string>
#include <vector>

#include "host/core/sensors/lidar.hpp"
#include "optim/calibration/path/odometry.hpp"

namespace simuli::calibration {

struct SpinReport {
  std::optional<SpinDirection> spin;
  double clockwise_m = 0.0;  // median distance of points to planes; infinity: no trajectory
  double counter_clockwise_m = 0.0;  // for either direction
  std::string reason;  // reason without a result
};

/// The same sweeps with times for either direction; about ten are sufficient.
[[nodiscard]] SpinReport find_spin(const std::vector<Returns>& clockwise,
                                   const std::vector<Returns>& counter_clockwise,
                                   const OdometryOptions& options = {});

}  // namespace simuli::calibration

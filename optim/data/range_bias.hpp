#pragma once
// Per-beam range calibration of a LiDAR, from surfaces seen by several rows.
#include <vector>

#include "io/log/frame_selection.hpp"

namespace simuli {

/// Range bias of a row and its uncertainty.
struct RangeBias {
  double bias_m = 0.0;  // measured minus true distance
  double sigma_m = 0.0;  // standard deviation of bias_m; +inf without information
};

/// Returns range biases of the rows of `lidar`, one of log.lidars: returns of training sweeps, placed by the
/// ego poses and the current biases, must lie on planes common to all rows (three rounds of robust least
/// squares). A bias common to all rows is not observable, so the median over rows is 0. Empty for fewer than 8
/// training sweeps. Throws Error{kInput} when a sweep cannot be read.
[[nodiscard]] std::vector<RangeBias> find_range_bias(const Log& log,
                                                     const LogLidar& lidar,
                                                     const FrameSelection& frames);

/// Returns the log with significant biases (5 standard deviations and 5 mm), for LiDARs that have none.
[[nodiscard]] Log with_range_bias(Log log, const FrameSelection& frames);

}  // namespace simuli

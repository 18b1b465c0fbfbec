#pragma once
// How far off each row of a LiDAR measures: learned from surfaces that several rows see.
#include <vector>

#include "io/log/frame_selection.hpp"

namespace simuli {

/// The range bias of a row, and what the sweeps say of it.
struct RangeBias {
  double bias_m = 0.0;   // measured less true distance
  double sigma_m = 0.0;  // standard deviation of bias_m; +inf where nothing tells it
};

/// Range biases of the rows of `lidar`, one of log.lidars: its training sweeps, each return where the path
/// and the row's own bias so far put it, must lie on the planes that all rows together see (three rounds of
/// robust least squares). A bias that all rows share is not told by planes, so the median of the rows is 0.
/// Empty for fewer than 8 training sweeps. Error{kInput} when a sweep can't be read.
[[nodiscard]] std::vector<RangeBias> find_range_bias(const Log& log,
                                                     const LogLidar& lidar,
                                                     const FrameSelection& frames);

/// The log with these biases where they count (5 standard deviations and 5 mm), in LiDARs that have none yet.
[[nodiscard]] Log with_range_bias(Log log, const FrameSelection& frames);

}  // namespace simuli

#pragma once
// Estimates the recorded range limit of a LiDAR from its sweeps; tables only contain the sensor's capability.
#include <optional>

#include "io/log/frame_selection.hpp"
#include "io/log/log.hpp"

namespace simuli {

/// Returns the range in m at which a recording was cut off: slightly more than the largest range of all
/// training sweeps, if returns are as dense in the last metre as in the metre before instead of becoming rare.
/// No value otherwise, or with fewer than 50 returns in that metre. Throws Error{kInput} when a sweep cannot be
/// read.
[[nodiscard]] std::optional<double> find_range_limit(const Log& log,
                                                     const LogLidar& lidar,
                                                     const FrameSelection& frames);

/// Returns the log with LiDARs limited to that range.
[[nodiscard]] Log with_range_limit(Log log, const FrameSelection& frames);

}  // namespace simuli

#pragma once
// How far a log's LiDAR was recorded: learned from its sweeps, as tables only tell what the sensor can do.
#include <optional>

#include "io/log/frame_selection.hpp"
#include "io/log/log.hpp"

namespace simuli {

/// The range in m beyond which a recording was cut off: a little more than the largest of all training
/// sweeps, where returns still come as densely in the last metre before it as in the one before that, instead
/// of getting fewer and fewer. Nothing where they do, or with fewer than 50 in that metre. Error{kInput} when
/// a sweep can't be read.
[[nodiscard]] std::optional<double> find_range_limit(const Log& log,
                                                     const LogLidar& lidar,
                                                     const FrameSelection& frames);

/// The log with LiDARs that reach no farther than that.
[[nodiscard]] Log with_range_limit(Log log, const FrameSelection& frames);

}  // namespace simuli

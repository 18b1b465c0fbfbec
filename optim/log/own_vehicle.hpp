#pragma once
// Where a mounted LiDAR sees nothing but the vehicle under it: learned from the sweeps, as no log tells.
#include <vector>

#include "io/log/frame_selection.hpp"

namespace simuli {

/// Arcs of every row of log.lidars[i] from which no training sweep has a return although the beam points at
/// the ground: 5 degrees and more below the horizon. Empty for a sensor with fewer than 8 training sweeps or
/// less than 5 m driven between its first and last: what stands beside a resting car is no part of it.
/// Error{kInput} when a sweep can't be read.
[[nodiscard]] std::vector<std::vector<BlindArc>> find_blind_arcs(const Log& log,
                                                                 const FrameSelection& frames);

/// The log with these arcs, in LiDARs that have none yet.
[[nodiscard]] Log with_blind_arcs(Log log, const FrameSelection& frames);

}  // namespace simuli

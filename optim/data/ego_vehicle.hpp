#pragma once
// Finds the directions in which a mounted LiDAR sees the ego vehicle, from the sweeps.
#include <vector>

#include "io/log/frame_selection.hpp"

namespace simuli {

/// Returns arcs of every row of log.lidars[i], at least 5 degrees below the horizon, that see the ego vehicle:
/// no training sweep has a return there although the beam points at the ground, with at least 5 m driven
/// between the first and the last sweep, because surroundings of a parked car are no part of it; or, with at
/// least 1 m driven, returns nearer than 3 m, within 1.25 m of the rig's middle and less than half as far below
/// the sensor as the ground, are at a constant position in the rig (0.1 m). Empty for a sensor with fewer than
/// 8 training sweeps. Throws Error{kInput} when a sweep cannot be read.
[[nodiscard]] std::vector<std::vector<BlindArc>> find_blind_arcs(const Log& log,
                                                                 const FrameSelection& frames);

/// Returns the log with these arcs for LiDARs that have none.
[[nodiscard]] Log with_blind_arcs(Log log, const FrameSelection& frames);

}  // namespace simuli

#pragma once
// Where a mounted LiDAR sees the vehicle under it: learned from the sweeps, as no log tells.
#include <vector>

#include "io/log/frame_selection.hpp"

namespace simuli {

/// Arcs of every row of log.lidars[i], 5 degrees and more below the horizon, that look at the vehicle itself:
/// no training sweep has a return from there although the beam points at the ground, and 5 m are driven
/// between the first and the last: what stands beside a resting car is no part of it; or 1 m is driven, and
/// returns from nearer than 3 m, within 1.25 m of the rig's middle and less than half as far below the sensor as
/// the ground, stay in one place of the vehicle (0.1 m). Empty for a sensor with fewer than 8 training sweeps.
/// Error{kInput} when a sweep can't be read.
[[nodiscard]] std::vector<std::vector<BlindArc>> find_blind_arcs(const Log& log,
                                                                 const FrameSelection& frames);

/// The log with these arcs, in LiDARs that have none yet.
[[nodiscard]] Log with_blind_arcs(Log log, const FrameSelection& frames);

}  // namespace simuli

#pragma once
// Learns LiDAR parameters that logs do not contain from their sweeps, before a scene is initialised.
#include "io/log/frame_selection.hpp"

namespace simuli {

/// Returns the log with LiDAR parameters learned from its training sweeps (range_bias.hpp, ego_vehicle.hpp,
/// range_limit.hpp). Throws Error{kInput} when a sweep cannot be read.
[[nodiscard]] Log with_learned_sensors(Log log, const FrameSelection& frames);

}  // namespace simuli

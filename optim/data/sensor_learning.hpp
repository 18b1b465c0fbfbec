#pragma once
// What no log tells of its LiDARs and its sweeps do: learned before a scene is made of them.
#include "io/log/frame_selection.hpp"

namespace simuli {

/// The log with what its training sweeps say of its LiDARs (range_bias.hpp, ego_vehicle.hpp, range_limit.hpp).
/// Error{kInput} when a sweep can't be read.
[[nodiscard]] Log with_learned_sensors(Log log, const FrameSelection& frames);

}  // namespace simuli

#pragma once
// Which frames of a drive were taken together: the moments of its rig.
#include <cstddef>
#include <vector>

#include "io/log/log.hpp"

namespace simuli {

/// [log.images], [log.sweeps]: the number of each frame among those of its sensor, by time. Sensors that fire
/// as often as each other (to a quarter of the period) have the same numbers where they fire together, each at
/// its own phase of the period, whatever frames are missing of any.
struct RigMoments {
  std::vector<std::size_t> images, sweeps;
};
[[nodiscard]] RigMoments rig_moments(const Log& log);

}  // namespace simuli

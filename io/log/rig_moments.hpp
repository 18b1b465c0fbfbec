#pragma once
// Groups of frames that the sensors of a rig take at the same time: its moments.
#include <cstddef>
#include <vector>

#include "io/log/log.hpp"

namespace simuli {

/// The number of the moment of each frame of log.images and log.sweeps. Sensors with the same period (to a quarter of
/// it) share their moments, each firing at its own phase of the period; frames missing from a sensor do not shift its
/// numbers.
struct RigMoments {
  std::vector<std::size_t> images, sweeps;
};
[[nodiscard]] RigMoments rig_moments(const Log& log);

}  // namespace simuli

#pragma once
// What no log tells of its LiDARs and its sweeps do: learned before a scene is made of them.
#include "io/log/log.hpp"

namespace simuli {

struct SensorLearning {
  bool range_bias = true;   // how far off each row measures (range_bias.hpp)
  bool own_vehicle = true;  // where the vehicle hides the world (own_vehicle.hpp)
};

/// The log with what its training sweeps say of its LiDARs. Error{kInput} when a sweep can't be read.
[[nodiscard]] Log with_learned_sensors(Log log, int held_out_every, const SensorLearning& what);

}  // namespace simuli

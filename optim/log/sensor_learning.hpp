#pragma once
// What no log tells of its LiDARs and its sweeps do: learned before a scene is made of them.
#include "io/log/frame_selection.hpp"

namespace simuli {

struct SensorLearning {
  bool range_bias = true;   // see range_bias.hpp
  bool own_vehicle = true;  // see own_vehicle.hpp
  bool range_limit = true;  // see range_limit.hpp
};
template <class F>
constexpr void visit_fields(SensorLearning& o, F&& field) {
  field("init.range_bias", o.range_bias, "find the LiDARs' range biases by row first");
  field(
      "init.own_vehicle", o.own_vehicle, "find the LiDARs' blind arcs, where the own vehicle stands, first");
  field("init.range_limit", o.range_limit, "find the range at which the LiDARs' recordings end first");
}

/// The log with what its training sweeps say of its LiDARs. Error{kInput} when a sweep can't be read.
[[nodiscard]] Log with_learned_sensors(Log log, const FrameSelection& frames, const SensorLearning& what);

}  // namespace simuli

#pragma once
#include "host/core/base/allowed.hpp"

namespace simuli {

/// Learning of actors' key poses: steps of Adam at the start, which fall exponentially to final_share of that.
/// Four times these win back, alone, 16 % of 25 cm of noise and -8.5 % of that in turn (`bench --actors`).
struct PoseRates {
  bool learn = false;
  double shift_m = 0.005;
  double turn_rad = 0.001;
  double final_share = 0.1;
};
template <class F>
constexpr void visit_fields(PoseRates& o, F&& field) {
  field.group("Actors");
  field(
      "actors.track.learn",
      o.learn,
      "Learn corrections of the actors' tracks while training. true: for labels that are off by decimetres.");
  field.internal(o.shift_m);
  field.internal(o.turn_rad);
  field.internal(o.final_share);
}

}  // namespace simuli

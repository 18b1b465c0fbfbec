#pragma once
#include "host/base/allowed.hpp"

namespace simuli {

/// Steps of Adam on key poses of actors, at the start. All fall exponentially to final_share of what they
/// were.
struct PoseRates {
  double shift_m = 0.0;
  double turn_rad = 0.0;
  double final_share = 0.1;
};
template <class F>
constexpr void visit_fields(PoseRates& o, F&& field) {
  field("actors.rate.shift_m",
        o.shift_m,
        at_least(0.0),
        "m per step of Adam, of tracks; 0: positions as recorded");
  field("actors.rate.turn_rad", o.turn_rad, at_least(0.0), "rad per step; 0: rotations as recorded");
  field("actors.rate.final_share", o.final_share, above(0.0, 1.0), "of both rates, at the end");
}

}  // namespace simuli

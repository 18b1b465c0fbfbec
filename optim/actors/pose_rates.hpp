#pragma once
#include "host/core/base/allowed.hpp"

namespace simuli {

/// Learning rates of actors' key poses per step of Adam, decaying exponentially to final_share
/// (docs/DECISIONS.md, "Actors").
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
      "Learn corrections of the actors' tracks while training. true: for labels with errors of decimetres.");
  field.internal(o.shift_m);
  field.internal(o.turn_rad);
  field.internal(o.final_share);
}

}  // namespace simuli

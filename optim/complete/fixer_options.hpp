#pragma once
// Options of external programs that repair off-trajectory pictures for training.
#include "host/core/base/allowed.hpp"

namespace simuli {

struct FixerOptions {
  int rounds = 2;  // number of calls, evenly spread over the second half of the training
  double shift_m = 1.5;
  int views = 10;
  double weight = 0.5;  // weight of a repaired picture's loss relative to a recorded one's
};
template <class F>
constexpr void visit_fields(FixerOptions& o, F&& field) {
  field.group("Fixer");
  field.internal(o.rounds);
  field("fixer.shift_m",
        o.shift_m,
        above(0.0, 10.0),
        "Distance in m to either side of the path from which it gets pictures.");
  field("fixer.views",
        o.views,
        range(1, 1000),
        "Recorded pictures that are taken again from either side. More: more of the drive, more calls.");
  field.internal(o.weight);
}

}  // namespace simuli

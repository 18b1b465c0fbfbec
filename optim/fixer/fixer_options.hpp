#pragma once
// Pictures from beside the path that a program of the user's mends, to learn from.
#include "host/base/allowed.hpp"

namespace simuli {

struct FixerOptions {
  double first_share = 0.5;
  int rounds = 2;
  double shift_m = 1.5;
  int views = 10;
  int every = 2;
  double weight = 0.5;
};
template <class F>
constexpr void visit_fields(FixerOptions& o, F&& field) {
  field("fixer.first_share",
        o.first_share,
        range(0.0, 1.0),
        "of the iterations, when the program is first asked");
  field("fixer.rounds",
        o.rounds,
        at_least(1),
        "how often it is asked, evenly over the iterations that are left");
  field("fixer.shift_m",
        o.shift_m,
        above(0.0, 10.0),
        "m, to either side of the path, that its pictures are taken");
  field("fixer.views", o.views, range(1, 1000), "recorded pictures that are taken again from either side");
  field("fixer.every", o.every, at_least(1), "iterations per mended picture");
  field("fixer.weight", o.weight, at_least(0.0), "of a mended picture's loss over a recorded one's");
}

}  // namespace simuli

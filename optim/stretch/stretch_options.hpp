#pragma once
// What a training by stretches of the drive is told.
#include "host/base/allowed.hpp"

namespace simuli {

/// A long drive is cut along its path; each stretch is trained by itself, on its own frames and those a
/// little before and behind it (METHOD section 10, Stretches).
struct StretchOptions {
  double length_m = 0.0;
  double overlap_m = 100.0;
};
template <class F>
constexpr void visit_fields(StretchOptions& o, F&& field) {
  field("stretch.length_m",
        o.length_m,
        zero_or(at_least(1.0)),
        "m of path that are trained at a time, about: memory is a stretch's then, not the drive's; 0: all at "
        "once");
  field(
      "stretch.overlap_m",
      o.overlap_m,
      above(0.0),
      "m of path before and behind a stretch, some of whose frames it is trained on, too: all near it, every "
      "eleventh at the end");
}

}  // namespace simuli

#pragma once
// What a training by stretches of the drive is told.
#include <cstddef>
#include <cstdint>

#include "host/base/allowed.hpp"

namespace simuli {

/// A long drive is cut along its path; each stretch is trained by itself, on its own frames and those a
/// little before and behind it (METHOD section 10, Stretches).
struct StretchOptions {
  double length_m = 0.0;
  double overlap_m = 20.0;
  double beside = 0.5;
  std::size_t host_memory_bytes = 0;
};
template <class F>
constexpr void visit_fields(StretchOptions& o, F&& field) {
  field("stretch.length_m",
        o.length_m,
        zero_or(at_least(1.0)),
        "m of path that are trained at a time, about: memory is a stretch's then, not the drive's; 0: all at "
        "once");
  field("stretch.overlap_m",
        o.overlap_m,
        above(0.0),
        "m of path before and behind a stretch, some of whose frames it is trained on, too: those that show "
        "it");
  field(
      "stretch.beside",
      o.beside,
      range(0.0, 100.0),
      "frames of those, for each that shows nothing but the stretch: one of which a tenth shows it counts a "
      "tenth");
  field("host_memory_bytes",
        o.host_memory_bytes,
        at_least(0),
        "of the host, that the training may need: a long drive is cut into stretches that fit, and into "
        "memory_bytes of the device, too; 0: not limited");
}

/// Into how many stretches a training was cut to fit in memory, and what one of them needs, as foretold.
struct StretchPlan {
  std::size_t count = 0;  // 0: nothing was asked to fit
  double length_m = 0.0;
  std::uint64_t host_bytes = 0, device_bytes = 0;
};

}  // namespace simuli

#pragma once
// What a training by stretches of the drive is told.
#include <cstddef>
#include <cstdint>

#include "host/core/base/allowed.hpp"

namespace simuli {

/// A long drive is cut along its path; each stretch is trained by itself, on its own frames and those a
/// little before and behind it (METHOD section 10, Stretches).
struct StretchOptions {
  double length_m = 0.0;
  double overlap_m = 20.0;  // of path before and behind a stretch, some of whose frames it is trained on, too
  /// Frames of those for each that shows nothing but the stretch. 2 are as good and take 15 % more time; all
  /// near a stretch lose 0.6 dB (the long street).
  double beside = 0.5;
  std::size_t host_memory_bytes = 0;
};
template <class F>
constexpr void visit_fields(StretchOptions& o, F&& field) {
  field.group("Memory");
  field("stretch.length_m",
        o.length_m,
        zero_or(at_least(1.0)),
        "Length in m of the stretches of path that are trained one after the other. Shorter: less memory; 0: "
        "all at once.");
  field("host_memory_bytes",
        o.host_memory_bytes,
        at_least(0),
        "Bytes of the host's memory that training may use; a drive that needs more is cut into stretches. 0: "
        "not limited.");
  field.keyless(o.overlap_m);
  field.keyless(o.beside);
}

/// Into how many stretches a training was cut to fit in memory, and what one of them needs, as foretold.
struct StretchPlan {
  std::size_t count = 0;  // 0: nothing was asked to fit
  double length_m = 0.0;
  std::uint64_t host_bytes = 0, device_bytes = 0;
};

}  // namespace simuli

#pragma once
// What a training by chunks of the drive is told.
#include <cstddef>
#include <cstdint>

#include "host/core/base/allowed.hpp"

namespace simuli {

/// A long drive is cut along its path; each chunk is trained by itself, on its own frames and those a
/// little before and behind it (METHOD section 10, Stretches).
struct ChunkOptions {
  double length_m = 0.0;
  double overlap_m = 20.0;  // of path before and behind a chunk, some of whose frames it is trained on, too
  /// Frames of those for each that shows nothing but the chunk. 2 are as good and take 15 % more time; all
  /// near a chunk lose 0.6 dB (the long street).
  double overlap_share = 0.5;
  std::size_t host_memory_bytes = 0;
};
template <class F>
constexpr void visit_fields(ChunkOptions& o, F&& field) {
  field.group("Memory");
  field("chunk.length_m",
        o.length_m,
        zero_or(at_least(1.0)),
        "Length in m of the stretches of path that are trained one after the other. Shorter: less memory; 0: "
        "all at once.");
  field("host_memory_bytes",
        o.host_memory_bytes,
        at_least(0),
        "Bytes of the host's memory that training may use; a drive that needs more is cut into stretches. 0: "
        "not limited.");
  field.internal(o.overlap_m);
  field.internal(o.overlap_share);
}

/// Into how many chunks a training was cut to fit in memory, and what one of them needs, as estimated.
struct ChunkPlan {
  std::size_t count = 0;  // 0: nothing was asked to fit
  double length_m = 0.0;
  std::uint64_t host_bytes = 0, device_bytes = 0;
};

}  // namespace simuli

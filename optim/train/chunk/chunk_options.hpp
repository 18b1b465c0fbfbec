#pragma once
// Options of a training by chunks of the drive.
#include <cstddef>
#include <cstdint>

#include "host/core/base/allowed.hpp"

namespace simuli {

/// A long drive is cut along its path into chunks. Each chunk is trained by itself, on its own frames and on
/// some frames shortly before and after it (METHOD section 10, "Chunks").
struct ChunkOptions {
  double length_m = 0.0;
  double overlap_m = 20.0;  // length of path before and after a chunk from which it takes additional frames
  /// Additional frames per sensor, as a multiple of the frames that show only the chunk (docs/DECISIONS.md,
  /// "Long drives").
  double overlap_share = 0.5;
  std::size_t host_memory_bytes = 0;
};
template <class F>
constexpr void visit_fields(ChunkOptions& o, F&& field) {
  field.group("Memory");
  field("chunk.length_m",
        o.length_m,
        zero_or(at_least(1.0)),
        "Length in m of chunks of the trajectory that are trained in sequence. Shorter: less memory; 0: a "
        "single chunk.");
  field("host_memory_bytes",
        o.host_memory_bytes,
        at_least(0),
        "Limit of host memory in bytes; a drive that needs more is split into chunks. 0: not limited.");
  field.internal(o.overlap_m);
  field.internal(o.overlap_share);
}

/// The number of chunks that fits in memory, and the estimated memory of one chunk.
struct ChunkPlan {
  std::size_t count = 0;  // 0: the number was not planned
  double length_m = 0.0;
  std::uint64_t host_bytes = 0, device_bytes = 0;
};

}  // namespace simuli

#pragma once
// When the frames of a drive were recorded.
#include <map>
#include <string>
#include <vector>

#include "io/log/log.hpp"

namespace simuli {

/// Of one frame, from its first to its last ray: seconds of the log.
struct FrameSpan {
  double time_start_s = 0.0;
  double time_end_s = 0.0;
};
/// Of each sensor's frames, by its name; by time.
using FrameSpans = std::map<std::string, std::vector<FrameSpan>>;

/// Sensors without frames are left out.
[[nodiscard]] FrameSpans frame_spans(const Log& log);

}  // namespace simuli

#pragma once
// Recording times of the frames of a drive.
#include <map>
#include <string>
#include <vector>

#include "io/log/log.hpp"

namespace simuli {

/// The times of a frame's first and last ray, in seconds of the log.
struct FrameSpan {
  double time_start_s = 0.0;
  double time_end_s = 0.0;
};
/// The spans of each sensor's frames in time order, by sensor name.
using FrameSpans = std::map<std::string, std::vector<FrameSpan>>;

/// Returns the spans of a log's frames; sensors without frames are left out.
[[nodiscard]] FrameSpans frame_spans(const Log& log);

}  // namespace simuli

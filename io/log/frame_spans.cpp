#include "io/log/frame_spans.hpp"

namespace simuli {

FrameSpans frame_spans(const Log& log) {
  FrameSpans spans;
  for (const ImageFrame& f : log.images) spans[f.camera].push_back({f.time_start_s, f.time_end_s});
  for (const SweepFrame& f : log.sweeps) spans[f.lidar].push_back({f.time_start_s, f.time_end_s});
  return spans;
}

}  // namespace simuli

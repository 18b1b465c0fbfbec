#include "io/log/frame_selection.hpp"

#include <fmt/format.h>

#include "host/base/error.hpp"

namespace simuli {

void validate(const FrameSelection& frames) {
  const auto need = [](bool holds, const char* field, double found, const char* allowed) {
    if (holds) return;
    throw Error(ErrorKind::kUsage, fmt::format("frames: {}: found {}, allowed {}", field, found, allowed));
  };
  const double scale = frames.image_scale;
  need(scale > 0.0 && scale <= 1.0, "image_scale", scale, "above 0, at most 1");
  const int every = frames.held_out_every;
  need(every >= 0 && every != 1, "held_out_every", every, "0 or at least 2");
}

}  // namespace simuli

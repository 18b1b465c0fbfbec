#pragma once
// Which frames of a log a scene is made from, and at which size: the same for its start, its training and,
// unless asked otherwise, its evaluation.
#include <cstdint>

namespace simuli {

struct FrameSelection {
  double image_scale = 0.5;  // (0, 1]: sides of the pictures over the recorded ones
  int held_out_every = 5;    // frames for which is_held_out() says yes are not read; 0: all are trained on
  std::uint64_t seed = 1;    // of the frames' order, and of which points go when there are too many
};

/// Error{kUsage} naming the field when one is outside its range.
void validate(const FrameSelection& frames);

}  // namespace simuli

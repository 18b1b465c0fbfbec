#pragma once
// Which frames of a log a scene is made from, and at which size: the same for its start, its training and,
// unless asked otherwise, its evaluation.
#include <cstdint>

#include "host/base/allowed.hpp"

namespace simuli {

struct FrameSelection {
  double image_scale = 0.5;
  int held_out_every = 5;  // frames for which is_held_out() says yes are not read
  std::uint64_t seed = 1;  // of the frames' order, and of which points go when there are too many
};

/// The keys that users set, with what is allowed and what it means (host/base/fields.hpp).
template <class F>
constexpr void visit_fields(FrameSelection& o, F&& field) {
  field("image_scale", o.image_scale, above(0.0, 1.0), "size of the training pictures over the recorded");
  field("held_out_every",
        o.held_out_every,
        zero_or(at_least(2)),
        "every so many frames, one is kept for evaluation; 0: all are trained on");
  field("seed", o.seed, at_least(0), "of the frames' order and of thinning");
}

}  // namespace simuli

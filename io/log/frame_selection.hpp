#pragma once
// Which frames of a log a scene is made from, and at which size: the same for its start, its training and,
// unless asked otherwise, its evaluation.
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "host/core/base/allowed.hpp"
#include "io/log/log.hpp"

namespace simuli {

struct FrameSelection {
  double image_scale = 0.5;
  int held_out_every = 5;
  double held_out_middle = 0.0;
  double held_out_last = 0.0;
  std::uint64_t seed = 1;  // of the frames' order, and of which points go when there are too many
};

/// The keys that users set, with what is allowed and what it means (host/core/base/fields.hpp).
template <class F>
constexpr void visit_fields(FrameSelection& o, F&& field) {
  field.group("Data");
  field("image_scale",
        o.image_scale,
        above(0.0, 1.0),
        "Size of the training pictures over the recorded ones. 1: sharpest, four times the pixels of 0.5.");
  field("held_out_every",
        o.held_out_every,
        zero_or(at_least(2)),
        "Keep every N-th picture and sweep for evaluation; 0: train on all frames.");
  field("held_out_middle",
        o.held_out_middle,
        range(0.0, 0.9),
        "Keep the frames on this share of the path, around its middle, for evaluation as well.");
  field("held_out_last",
        o.held_out_last,
        range(0.0, 0.9),
        "Keep the frames on this share of the path, at its end, for evaluation as well.");
  field("seed",
        o.seed,
        at_least(0),
        "Seed of the frames' order and of thinning. Another seed shows how much results scatter.");
}

/// "every 5. frame, the last 20 % of the path": what is held out; empty: nothing.
[[nodiscard]] std::string held_out_text(const FrameSelection& frames);

/// The same selection, but that every frame is trained on.
[[nodiscard]] FrameSelection nothing_held_out(FrameSelection frames);

/// What a frame is to a training.
enum class FrameUse {
  kTraining,
  kBetween,  // held out, training frames before and behind: what a scene makes of what it saw
  kMiddle,   // held out in a stretch of the path that training saw from either end alone
  kBeyond,   // held out at the end of the path, where training read nothing: what it makes of the rest
};

/// The one rule by which frames of a log are held out: with held_out_every = N those with index % N == N - 1;
/// with held_out_last those that end when the rig has that share of its path, by length, still before it, or
/// later; with held_out_middle those during which it is in the part of that share around the path's middle.
/// Together they hold out what any does; a frame behind the cut is kBeyond and one in the middle kMiddle
/// whatever its index.
class HeldOutRule {
 public:
  /// Error{kInput} when a share of a path is asked for that is 0 m long.
  HeldOutRule(const Log& log, const FrameSelection& frames);

  /// Of the frame at `index` among the log's pictures or its sweeps.
  template <class Frame>
  [[nodiscard]] FrameUse use(std::size_t index, const Frame& frame) const {
    if (frame.time_end_s > cut_s_) return FrameUse::kBeyond;
    if (frame.time_end_s > middle_s_[0] && frame.time_start_s < middle_s_[1]) return FrameUse::kMiddle;
    return every_ > 0 && index % every_ == every_ - 1 ? FrameUse::kBetween : FrameUse::kTraining;
  }
  /// Indices of the frames that training reads, and of all others.
  template <class Frame>
  [[nodiscard]] std::vector<std::size_t> training(const std::vector<Frame>& frames) const {
    return select(frames, true);
  }
  template <class Frame>
  [[nodiscard]] std::vector<std::size_t> held_out(const std::vector<Frame>& frames) const {
    return select(frames, false);
  }

 private:
  template <class Frame>
  [[nodiscard]] std::vector<std::size_t> select(const std::vector<Frame>& frames, bool trained) const {
    std::vector<std::size_t> selected;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      if ((use(i, frames[i]) == FrameUse::kTraining) == trained) selected.push_back(i);
    }
    return selected;
  }

  std::size_t every_;
  double cut_s_ = std::numeric_limits<double>::infinity();
  std::array<double, 2> middle_s_{cut_s_, cut_s_};  // from, until
};

}  // namespace simuli

#include "optim/eval/eval_frames.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "host/core/base/error.hpp"
#include "host/core/base/fields.hpp"
#include "optim/base/frames.hpp"

namespace simuli {
namespace {

template <class Frame>
std::vector<FrameUse> uses_of(const std::vector<Frame>& frames, const HeldOutRule& rule) {
  std::vector<FrameUse> uses;
  for (std::size_t i = 0; i < frames.size(); ++i) uses.push_back(rule.use(i, frames[i]));
  return uses;
}

/// Number of compared frames with that use.
std::size_t count_of(const EvalFrames& frames, FrameUse use) {
  const auto count = [use](const std::vector<std::size_t>& compared, const std::vector<FrameUse>& uses) {
    if (uses.empty()) return std::ptrdiff_t{0};
    return std::count_if(compared.begin(), compared.end(), [&](std::size_t i) { return uses[i] == use; });
  };
  return static_cast<std::size_t>(count(frames.images, frames.image_uses) +
                                  count(frames.sweeps, frames.sweep_uses));
}

/// Sets the frames' uses by the training's rule.
void take_uses(EvalFrames& frames, const Log& log, const FrameSelection& made) {
  const HeldOutRule rule(log, made);
  frames.image_uses = uses_of(log.images, rule);
  frames.sweep_uses = uses_of(log.sweeps, rule);
  const std::size_t read = count_of(frames, FrameUse::kTraining);
  if (read == 0) {
    frames.kind = FrameKind::kHeldOut;
    return;
  }
  frames.kind =
      read == frames.images.size() + frames.sweeps.size() ? FrameKind::kTraining : FrameKind::kMixed;
  frames.image_uses.clear();
  frames.sweep_uses.clear();
}

/// Applies a requested rule instead of the training's, completely or not at all.
void take_rule(const EvalOptions& options, FrameSelection& as) {
  if (!options.held_out_every && !options.held_out_middle && !options.held_out_last &&
      !options.held_out_sensors) {
    return;
  }
  as.held_out_every = options.held_out_every.value_or(0);
  as.held_out_middle = options.held_out_middle.value_or(0.0);
  as.held_out_last = options.held_out_last.value_or(0.0);
  as.held_out_sensors = options.held_out_sensors.value_or(std::vector<std::string>{});
}

}  // namespace

const char* to_string(FrameKind kind) {
  switch (kind) {
    case FrameKind::kHeldOut:
      return "held_out";
    case FrameKind::kTraining:
      return "training";
    case FrameKind::kMixed:
      return "mixed";
    case FrameKind::kOtherLog:
      return "other_log";
    case FrameKind::kUnknown:
      break;
  }
  return "unknown";
}

bool EvalFrames::has(FrameUse use) const { return count_of(*this, use) > 0; }

std::string EvalFrames::label() const {
  const std::string rule = held_out_text(requested), which = rule.empty() ? "all frames" : rule;
  switch (kind) {
    case FrameKind::kHeldOut:
      if (has(FrameUse::kBetween)) return "held-out frames";
      if (has(FrameUse::kSensor)) {
        return has(FrameUse::kMiddle) || has(FrameUse::kBeyond) ? "held-out frames"
                                                                : "frames of held-out sensors";
      }
      if (!has(FrameUse::kBeyond)) return "held-out frames in the middle of the path";
      return has(FrameUse::kMiddle) ? "held-out frames in the middle and at the end of the path"
                                    : "held-out frames at the end of the path";
    case FrameKind::kTraining:
      return "training frames";
    case FrameKind::kMixed:
      return which + ", some of which were trained on";
    case FrameKind::kOtherLog:
      return which + " of a log that was not trained on";
    case FrameKind::kUnknown:
      break;
  }
  return which + " (the scene has no record of its training frames)";
}

EvalFrames select_eval_frames(const Log& log, const SceneFile& scene, const EvalOptions& options) {
  const TrainingRecord* const made = scene.training ? &*scene.training : nullptr;
  const bool other_log = made != nullptr && made->log_hash != log_hash(log);
  FrameSelection as = made != nullptr ? made->frames : FrameSelection{};
  if (other_log) as = nothing_held_out(as);
  as.image_scale = options.image_scale.value_or(as.image_scale);
  take_rule(options, as);
  check_fields(as);
  EvalFrames frames{.requested = as};
  const HeldOutRule rule(log, as);
  const bool all = held_out_text(as).empty();  // otherwise the rule's held-out frames
  frames.images = all ? rule.training(log.images) : rule.held_out(log.images);
  frames.sweeps = all ? rule.training(log.sweeps) : rule.held_out(log.sweeps);
  if (frames.images.empty() && frames.sweeps.empty()) {
    throw_input_error(
        log.folder.string(),
        "frames to compare",
        "0",
        fmt::format("at least one: a log of {} frames or more", std::max(as.held_out_every, 1)));
  }
  if (other_log) {
    frames.kind = FrameKind::kOtherLog;
  } else if (made != nullptr) {
    take_uses(frames, log, made->frames);
  }
  return frames;
}

}  // namespace simuli

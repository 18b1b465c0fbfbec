#include "optim/eval/eval_frames.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "host/base/error.hpp"
#include "host/base/fields.hpp"
#include "optim/base/frames.hpp"

namespace simuli {
namespace {

FrameKind kind_of(const EvalFrames& frames, const TrainingRecord& made) {
  const auto was_read = [&](std::size_t index) { return !is_held_out(index, made.frames.held_out_every); };
  const auto read = std::count_if(frames.images.begin(), frames.images.end(), was_read) +
                    std::count_if(frames.sweeps.begin(), frames.sweeps.end(), was_read);
  if (read == 0) return FrameKind::kHeldOut;
  const auto all = static_cast<std::ptrdiff_t>(frames.images.size() + frames.sweeps.size());
  return read == all ? FrameKind::kTraining : FrameKind::kMixed;
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

std::string EvalFrames::label() const {
  const std::string which =
      held_out_every > 0 ? fmt::format("every {}. frame", held_out_every) : "all frames";
  switch (kind) {
    case FrameKind::kHeldOut:
      return "held-out frames";
    case FrameKind::kTraining:
      return "training frames";
    case FrameKind::kMixed:
      return which + ", some of which were trained on";
    case FrameKind::kOtherLog:
      return which + " of a log that was not trained on";
    case FrameKind::kUnknown:
      break;
  }
  return which + " (the scene does not say which were trained on)";
}

EvalFrames select_eval_frames(const Log& log,
                              const SceneFile& scene,
                              std::optional<double> image_scale,
                              std::optional<int> held_out_every) {
  const TrainingRecord* const made = scene.training ? &*scene.training : nullptr;
  const bool other_log = made != nullptr && made->log_hash != log_hash(log);
  FrameSelection as = made != nullptr ? made->frames : FrameSelection{};
  if (other_log) as.held_out_every = 0;
  as.image_scale = image_scale.value_or(as.image_scale);
  as.held_out_every = held_out_every.value_or(as.held_out_every);
  check_fields(as);
  const bool held_out = as.held_out_every > 0;  // else every frame is "not held out", and all are compared
  EvalFrames frames{.held_out_every = as.held_out_every,
                    .image_scale = as.image_scale,
                    .images = select_frames(log.images, as.held_out_every, held_out),
                    .sweeps = select_frames(log.sweeps, as.held_out_every, held_out)};
  if (frames.images.empty() && frames.sweeps.empty()) {
    throw_input_error(log.folder.string(),
                      "frames to compare",
                      "0",
                      fmt::format("at least one: a log of {} frames or more", as.held_out_every));
  }
  if (made != nullptr) frames.kind = other_log ? FrameKind::kOtherLog : kind_of(frames, *made);
  return frames;
}

}  // namespace simuli

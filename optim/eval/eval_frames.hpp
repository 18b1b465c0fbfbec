#pragma once
// Selects the frames of a log that a scene is compared with, and their use in its training.
#include <cstddef>
#include <string>
#include <vector>

#include "io/log/frame_selection.hpp"
#include "io/scene/scene_folder.hpp"
#include "optim/eval/eval_options.hpp"

namespace simuli {

enum class FrameKind {
  kHeldOut,   // of the training log, not read by training
  kTraining,  // all were trained on
  kMixed,     // some were trained on
  kOtherLog,  // the scene was trained on another log
  kUnknown,   // the scene has no training record
};
/// "held_out", "training", "mixed", "other_log", "unknown".
[[nodiscard]] const char* to_string(FrameKind kind);

struct EvalFrames {
  FrameKind kind = FrameKind::kUnknown;
  FrameSelection requested = {};                      // picture size and rule; without a rule all frames
                                                      // held out: all frames
  std::vector<std::size_t> images = {}, sweeps = {};  // indices into the log's frames
  /// [log.images], [log.sweeps]: use of each frame in the scene's training; empty unless kind is kHeldOut.
  std::vector<FrameUse> image_uses = {}, sweep_uses = {};

  /// Whether frames of that use are compared.
  [[nodiscard]] bool has(FrameUse use) const;
  /// "held-out frames", "training frames", ...
  [[nodiscard]] std::string label() const;
};

/// Returns the frames by the training's size and rule, or those that `options` request. For another log no
/// frame is held out: all frames, unless a rule is requested. Throws Error{kUsage} for a size or rule outside
/// its range, Error{kInput} when no frame is left.
[[nodiscard]] EvalFrames select_eval_frames(const Log& log,
                                            const SceneFile& scene,
                                            const EvalOptions& options = {});

}  // namespace simuli

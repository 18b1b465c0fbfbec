#pragma once
// Which frames of a log a scene is compared with, and what they are to it.
#include <cstddef>
#include <string>
#include <vector>

#include "io/log/frame_selection.hpp"
#include "io/scene/scene_folder.hpp"
#include "optim/eval/eval_options.hpp"

namespace simuli {

enum class FrameKind {
  kHeldOut,   // of the log that the scene was trained on, and none of them was read
  kTraining,  // it was trained on each
  kMixed,     // on some
  kOtherLog,  // the scene was trained on another log
  kUnknown,   // the scene does not say what it was trained on
};
/// "held_out", "training", "mixed", "other_log", "unknown".
[[nodiscard]] const char* to_string(FrameKind kind);

struct EvalFrames {
  FrameKind kind = FrameKind::kUnknown;
  FrameSelection asked = {};                          // size of the pictures, and what is compared; nothing
                                                      // held out: all frames
  std::vector<std::size_t> images = {}, sweeps = {};  // indices into the log's
  /// [log.images], [log.sweeps]: what each frame was to the scene's training; empty unless kind is kHeldOut.
  std::vector<FrameUse> image_uses = {}, sweep_uses = {};

  /// Whether frames of that use are compared.
  [[nodiscard]] bool has(FrameUse use) const;
  /// "held-out frames", "training frames", ...
  [[nodiscard]] std::string label() const;
};

/// As the scene was trained, but for the size and the rule that `options` ask for. Of a log that it wasn't
/// trained on nothing is held out: all frames, unless a rule is asked for. Error{kUsage} for a size or a rule
/// outside its range, Error{kInput} when no frame is left.
[[nodiscard]] EvalFrames select_eval_frames(const Log& log,
                                            const SceneFile& scene,
                                            const EvalOptions& options = {});

}  // namespace simuli

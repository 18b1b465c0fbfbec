#pragma once
// Which frames of a log a scene is compared with, and what they are to it.
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "io/log/log.hpp"
#include "io/scene/scene_folder.hpp"

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
  int held_out_every = 0;                             // every that many frames; 0: all
  double image_scale = 1.0;                           // pictures are compared at this size
  std::vector<std::size_t> images = {}, sweeps = {};  // indices into the log's

  /// "held-out frames", "training frames", ...
  [[nodiscard]] std::string label() const;
};

/// As the scene was trained, but for what is asked for. Of a log that it wasn't trained on nothing is held
/// out: all frames, unless every N-th is asked for. Error{kUsage} for a size or a rule outside its range,
/// Error{kInput} when no frame is left.
[[nodiscard]] EvalFrames select_eval_frames(const Log& log,
                                            const SceneFile& scene,
                                            std::optional<double> image_scale,
                                            std::optional<int> held_out_every);

}  // namespace simuli

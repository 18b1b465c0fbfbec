#pragma once
// Common parts of benches that train scenes.
#include <filesystem>
#include <functional>
#include <string>

#include "host/device/runtime/device.hpp"
#include "io/base/temporary.hpp"
#include "io/log/log.hpp"
#include "io/synth/street.hpp"
#include "optim/eval/evaluation.hpp"
#include "optim/train/training.hpp"

namespace simuli::bench {

/// TrainOptions::anchor of the paper.
inline constexpr AnchorOptions kPaperAnchors{.weight = 0.01};

/// Receives one line of progress.
using Note = std::function<void(const std::string&)>;

/// Writes pictures and sweeps of the street for each frame of `log` to its folder, with the frame's sensor.
void write_frames(const Log& log, const Street& street);

/// Trains a scene on the frames of `log` that are not held out, as `simuli train` does.
[[nodiscard]] SceneFile fit(const Device& device, const Log& log, const TrainingOptions& options);
/// Evaluates the held-out frames of `log`: the log of the training, or another log with the same frames.
[[nodiscard]] EvalReport compare(const Device& device,
                                 const Log& log,
                                 const SceneFile& scene,
                                 EvalOptions options = {.timed_renders = 1});

}  // namespace simuli::bench

#pragma once
// What the benches that train scenes share.
#include <filesystem>
#include <functional>
#include <string>

#include "host/device/runtime/device.hpp"
#include "io/base/scratch_folder.hpp"
#include "io/log/log.hpp"
#include "io/synth/street.hpp"
#include "optim/eval/evaluation.hpp"
#include "optim/train/training.hpp"

namespace simuli::bench {

/// TrainOptions::anchor, as the paper has it.
inline constexpr AnchorOptions kPaperAnchors{.weight = 0.01};

/// Says one line to whoever waits.
using Note = std::function<void(const std::string&)>;

/// Pictures and sweeps of the street for each frame of `log`, into its folder, each by the sensor of that
/// name.
void write_frames(const Log& log, const Street& street);

/// A scene from the frames of `log` that are not held out, as `simuli train` makes it.
[[nodiscard]] SceneFile fit(const Device& device, const Log& log, const TrainingOptions& options);
/// On the frames of `log` that are held out when it is the one of the training: it may be another, with the
/// same frames.
[[nodiscard]] EvalReport compare(const Device& device,
                                 const Log& log,
                                 const SceneFile& scene,
                                 EvalOptions options = {.timed_renders = 1});

}  // namespace simuli::bench

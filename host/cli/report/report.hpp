#pragma once
// What a training or an evaluation came to, as one HTML file.
#include <filesystem>
#include <string>

#include "host/cli/report/training.hpp"

namespace simuli::cli {

/// Metrics, curves of the training (when `trained` is given), held-out pictures and sweeps beside what was
/// recorded, the LiDAR's tiles, the time of each kernel of a frame. Renders what it shows, on the device that
/// `globals` asks for. Atomic; Error{kInput} when the file can't be written.
void write_report(const std::filesystem::path& file,
                  const std::string& title,
                  const Globals& globals,
                  const Log& log,
                  const Scene& scene,
                  const EvalOptions& options,
                  const EvalReport& report,
                  const TrainedScene* trained);

}  // namespace simuli::cli

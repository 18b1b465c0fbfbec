#pragma once
// What a training or an evaluation came to, as one HTML file.
#include <filesystem>
#include <string>

#include "host/cli/report/training.hpp"

namespace simuli::cli {

/// A training and how it went.
struct TrainedReport {
  TrainingReport report;
  TrainHistory history;
};

/// Metrics, curves of the training (when `trained` is given), how the scene was made, pictures and sweeps
/// beside what was recorded, the LiDAR's tiles, the time of each kernel of a frame. Renders what it shows, on
/// the device that `globals` asks for. Atomic; Error{kInput} when the file can't be written.
void write_report(const std::filesystem::path& file,
                  const std::string& title,
                  const Globals& globals,
                  Evaluation& evaluation,
                  const EvalReport& report,
                  const TrainedReport* trained = nullptr);

}  // namespace simuli::cli

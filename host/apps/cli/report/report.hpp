#pragma once
// What a training or an evaluation came to, as one HTML file.
#include <filesystem>
#include <string>
#include <vector>

#include "host/apps/cli/report/training.hpp"

namespace simuli::cli {

/// A training and how it went.
struct TrainedReport {
  TrainingReport report;
  TrainHistory history;
};

/// What a report says beside its numbers.
struct ReportText {
  std::string title;
  std::vector<std::string> edits = {};     // of the scene, as they were given
  const TrainedReport* trained = nullptr;  // where it was trained just now
};

/// What matters most, pictures and sweeps beside what was recorded, what nobody recorded (a point cloud to
/// turn, depth, another lane, another lens and LiDAR, an actor gone), metrics, errors over the drive and by
/// range, curves of the training, all settings, the time of each kernel of a frame, the LiDAR's tiles. Renders
/// what it shows, on the device that `globals` asks for. Atomic; Error{kInput} when the file can't be written.
void write_report(const std::filesystem::path& file,
                  const ReportText& text,
                  const Globals& globals,
                  Evaluation& evaluation,
                  const EvalReport& report);

}  // namespace simuli::cli

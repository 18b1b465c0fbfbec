#pragma once
// Report of a training or an evaluation as one HTML file.
#include <filesystem>
#include <string>
#include <vector>

#include "host/apps/cli/report/training.hpp"

namespace simuli::cli {

/// A training and its history.
struct TrainedReport {
  TrainingReport report;
  TrainHistory history;
};

/// Texts of a report.
struct ReportText {
  std::string title;
  std::vector<std::string> edits = {};     // edits of the scene, as given
  const TrainedReport* trained = nullptr;  // if the scene was trained by this command
};

/// Writes a report: main scores, rendered beside recorded pictures and sweeps, unrecorded views (an interactive
/// point cloud, depth, another lane, another lens and LiDAR, an actor removed), metrics, errors along the drive
/// and by range, training curves, settings, kernel times of a frame, LiDAR tiles. Renders its pictures on the
/// device of `globals`. Atomic; throws Error{kInput} if the file cannot be written.
void write_report(const std::filesystem::path& file,
                  const ReportText& text,
                  const Globals& globals,
                  Evaluation& evaluation,
                  const EvalReport& report);

}  // namespace simuli::cli

#pragma once
// Measurements on drives as the table of the README.
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "optim/eval/evaluation.hpp"
#include "optim/train/training.hpp"

namespace simuli::bench {

/// One training and its scores on held-out frames.
struct DriveRow {
  std::string drive;
  bool labels = false;                // trained with the boxes of the log
  std::string frames;                 // description of the held-out frames
  std::vector<std::string> settings;  // settings that differ from the defaults of `simuli train`
  std::vector<std::pair<std::string, double>> values;  // by key with the unit in the name; NaN: not available

  [[nodiscard]] double value(const std::string& key) const;  // NaN if absent
  /// Returns "0013, boxes of the log" or "0052".
  [[nodiscard]] std::string title() const;
};

/// `train_s`: time of the training without initialisation, s. `processor_s`: CPU time of all threads, from
/// reading the log to the scene.
[[nodiscard]] std::vector<std::pair<std::string, double>> values_of(const EvalReport& report,
                                                                    const TrainingReport& training,
                                                                    double train_s,
                                                                    double processor_s);

/// Returns a table with one metric per line and one row of measurements per column.
[[nodiscard]] std::string to_markdown(const std::vector<DriveRow>& rows);
/// Returns an array with one object per row.
[[nodiscard]] std::string to_json(const std::vector<DriveRow>& rows);
/// Returns a one-line summary of the row.
[[nodiscard]] std::string to_line(const DriveRow& row);

/// Stores the row as a JSON file together with `identity`, a description of its inputs.
void keep_row(const std::filesystem::path& file, const DriveRow& row, const std::string& identity);
/// Returns no value if the file is missing or has another identity. Throws Error{kInput} for an invalid file.
[[nodiscard]] std::optional<DriveRow> kept_row(const std::filesystem::path& file,
                                               const std::string& identity);

}  // namespace simuli::bench

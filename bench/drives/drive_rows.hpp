#pragma once
// What is measured on a drive, as the table that the README has.
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "optim/eval/evaluation.hpp"
#include "optim/train/training.hpp"

namespace simuli::bench {

/// One training and what held-out frames say of it.
struct DriveRow {
  std::string drive;
  bool labels = false;                                 // trained with the log's own boxes
  std::string frames;                                  // that were held out, in words
  std::vector<std::string> settings;                   // other than `simuli train` has without any
  std::vector<std::pair<std::string, double>> values;  // by key, unit in the name; NaN: there is none

  [[nodiscard]] double value(const std::string& key) const;  // NaN when it isn't there
  /// "0013, boxes of the log", "0052".
  [[nodiscard]] std::string title() const;
};

/// `train_s`: seconds of the training without its start. `processor_s`: of all threads, from the log that was
/// read to the scene.
[[nodiscard]] std::vector<std::pair<std::string, double>> values_of(const EvalReport& report,
                                                                    const TrainingReport& training,
                                                                    double train_s,
                                                                    double processor_s);

/// Metrics downwards, a column for each row.
[[nodiscard]] std::string to_markdown(const std::vector<DriveRow>& rows);
/// An array with an object for each row.
[[nodiscard]] std::string to_json(const std::vector<DriveRow>& rows);
/// One line that tells of the row.
[[nodiscard]] std::string to_line(const DriveRow& row);

/// Rows that are kept: as one JSON file each, beside what they are of (`identity`).
void keep_row(const std::filesystem::path& file, const DriveRow& row, const std::string& identity);
/// Nothing when the file is not there or of another identity. Error{kInput} when it is no such file.
[[nodiscard]] std::optional<DriveRow> kept_row(const std::filesystem::path& file,
                                               const std::string& identity);

}  // namespace simuli::bench

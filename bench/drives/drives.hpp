#pragma once
// Measures recorded drives for the table of the README.
#include <filesystem>
#include <string>
#include <vector>

#include "bench/drives/drive_rows.hpp"
#include "bench/paper/drive_log.hpp"
#include "bench/paper/fit.hpp"

namespace simuli::bench {

struct DrivesOptions {
  std::vector<std::string> drives;  // in the format of open_drive()
  /// Iterations, ascending: one training and one row for each. Empty: the default.
  std::vector<std::string> lengths;
  std::vector<std::string> settings;  // "key=value", for all trainings
  /// Folder for rows, scenes and checkpoints; results with the same log, settings and program are reused.
  /// Empty: none.
  std::filesystem::path keep;
  /// Stops the trainings of a drive after the first whose held-out pictures reach this PSNR in dB; 0: never.
  double time_to_db = 0.0;
};

/// Trains on each drive with the defaults of `simuli train` and evaluates as `simuli eval` does. A drive with
/// boxes of moving objects is trained with and without them; the boxes define the pixels and rays of actors
/// in both cases. `note` receives each finished row and the remaining time.
[[nodiscard]] std::vector<DriveRow> run_drives(const std::string& device_request,
                                               const DrivesOptions& options,
                                               const Note& note);

}  // namespace simuli::bench

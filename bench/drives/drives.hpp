#pragma once
// What the program makes of recorded drives: the table that the README has.
#include <filesystem>
#include <string>
#include <vector>

#include "bench/drives/drive_rows.hpp"
#include "bench/paper/drive_log.hpp"
#include "bench/paper/fit.hpp"

namespace simuli::bench {

struct DrivesOptions {
  std::vector<std::string> drives;  // as open_drive() takes them
  /// Iterations, ascending: a training, and a row, for each. Empty: as many as by default.
  std::vector<std::string> lengths;
  std::vector<std::string> settings;  // "key=value" of every training
  /// Where rows, scenes and checkpoints are kept: what is there and of the same log, settings and program is
  /// not made again. Empty: nothing is kept.
  std::filesystem::path keep;
  /// Trainings of a drive end with the first whose held-out pictures have so many dB; 0: all are made.
  double time_to_db = 0.0;
};

/// Trains on each drive as `simuli train` does without options and compares as `simuli eval` does; a drive
/// whose log has boxes of things that move once with them and once without, boxes telling what is inside them
/// in both cases. `note` hears of each row when it is there, and of the time that is left.
[[nodiscard]] std::vector<DriveRow> run_drives(const std::string& device_request,
                                               const DrivesOptions& options,
                                               const Note& note);

}  // namespace simuli::bench

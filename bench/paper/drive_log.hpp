#pragma once
// Drives in the format of bench options: logs, folders of KITTI raw, the embedded street.
#include <filesystem>
#include <string>
#include <vector>

#include "io/log/log.hpp"

namespace simuli::bench {

/// A drive for trainings.
struct Drive {
  std::string name;
  Log log;                                 // with all available boxes
  std::vector<std::string> settings = {};  // "key=value" in addition to the defaults
};

/// Opens a drive: "street" (as made by `simuli synth street`, full size), a log folder, or a folder of KITTI
/// raw. Comma-separated options after the folder: "poses=FILE" and "labels=FILE", as --poses and --tracking
/// of `simuli import kitti`, and settings "KEY=VALUE" of the training. Imported or generated data are written
/// to `scratch`. Throws Error{kUsage} for other texts, and the importers' Error{kInput}.
[[nodiscard]] Drive open_drive(const std::string& text, const std::filesystem::path& scratch);

/// Returns the number in the name of a folder of KITTI raw ("2011_09_26_drive_0013_sync"), else the folder's
/// name without ".log".
[[nodiscard]] std::string drive_name(const std::filesystem::path& folder);

}  // namespace simuli::bench

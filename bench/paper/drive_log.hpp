#pragma once
// Drives as the bench is told of them: logs, folders of KITTI raw, the embedded street.
#include <filesystem>
#include <string>
#include <vector>

#include "io/log/log.hpp"

namespace simuli::bench {

/// A drive that can be trained on.
struct Drive {
  std::string name;
  Log log;                                 // with the boxes that there are
  std::vector<std::string> settings = {};  // "key=value" of its own beside the defaults
};

/// Opens what `text` names: "street" (as `simuli synth street` makes it, at full size), a log folder, or a
/// folder of KITTI raw; behind the folder "poses=FILE" and "labels=FILE", each after a comma, as `simuli
/// import kitti` takes them with --poses and --tracking, and settings of its training as "KEY=VALUE". What is
/// imported or made is written below `scratch`.
/// Error{kUsage} for anything else, Error{kInput} as the importers have it.
[[nodiscard]] Drive open_drive(const std::string& text, const std::filesystem::path& scratch);

/// Its number in the name of a folder of KITTI raw ("2011_09_26_drive_0013_sync"), else the folder's name
/// without ".log".
[[nodiscard]] std::string drive_name(const std::filesystem::path& folder);

}  // namespace simuli::bench

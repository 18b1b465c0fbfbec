#pragma once
#include <string>
#include <utility>

#include "host/apps/cli/base/command.hpp"
#include "host/apps/cli/base/file_progress.hpp"
#include "host/apps/cli/info/info.hpp"
#include "io/log/log.hpp"

namespace simuli::cli {

/// What every import does: `run(progress, report)` returns the log, `tell(report)` says on stderr what became
/// of what was recorded.
template <class Report, class Run, class Tell>
void run_import(const char* name, const Globals& globals, const Run& run, const Tell& tell) {
  FileProgress progress(std::string("import ") + name, globals);
  Report report;
  const Log log = run(progress.callback(), report);
  progress.finish();
  tell(report);
  print_log(log, globals.json);
}

/// The two sides of an option "FIRST=REST" or "FIRST:REST"; Error{kUsage} where one is missing.
[[nodiscard]] std::pair<std::string, std::string> parted(const char* option,
                                                         const std::string& text,
                                                         char at,
                                                         const char* first = "TOPIC");
/// What --lidar names: Error{kUsage} for a camera and for a list of rays.
[[nodiscard]] Lidar lidar_table(const std::string& name);

/// `import mcap`: recordings of ROS 2.
void add_import_ros2(Command import, const Globals& globals);
/// `import ncore`: NVIDIA's format of drives.
void add_import_ncore(Command import, const Globals& globals);

}  // namespace simuli::cli

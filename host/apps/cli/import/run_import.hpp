#pragma once
#include <charconv>
#include <cstddef>
#include <fmt/format.h>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/apps/cli/base/command.hpp"
#include "host/apps/cli/base/file_progress.hpp"
#include "host/apps/cli/base/refuse.hpp"
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

/// --frames a:b, and its ends each by itself.
template <class Options>
void add_frames(Command command, const std::shared_ptr<Options>& options, const char* whose) {
  command
      .option(
          "--frames",
          [options](const std::string& text) {
            const std::size_t colon = text.find(':');
            const auto number = [&](std::size_t from, std::size_t to, std::size_t& value) {
              const char* const end = text.data() + to;
              return std::from_chars(text.data() + from, end, value) == std::from_chars_result{end, {}};
            };
            if (colon == std::string::npos || !number(0, colon, options->first) ||
                !number(colon + 1, text.size(), options->last)) {
              refuse("--frames", text, "a:b, numbers of frames");
            }
          },
          "a:b, numbers of the first and the last frame")
      .shown_as("A:B", "");
  command.option("--first", options->first, "number of the first frame; default: 0").excludes("--frames");
  command.option("--last", options->last, fmt::format("number of the last frame; default: {}", whose))
      .excludes("--frames");
}

/// "3, 177 to 180"; what is beyond the tenth run is only told to be there.
[[nodiscard]] std::string runs_text(const std::vector<std::size_t>& numbers);
/// The two sides of an option "FIRST=REST" or "FIRST:REST"; Error{kUsage} where one is missing.
[[nodiscard]] std::pair<std::string, std::string> parted(const char* option,
                                                         const std::string& text,
                                                         char at,
                                                         const char* first = "TOPIC");
/// What --lidar names: Error{kUsage} for a camera and for a list of rays.
[[nodiscard]] Lidar lidar_table(const std::string& name);

/// `import mcap`: recordings of ROS 2.
void add_import_ros2(Command import, const Globals& globals);
/// `import pandaset`: sequences of PandaSet.
void add_import_pandaset(Command import, const Globals& globals);
/// `import ncore`: NVIDIA's format of drives.
void add_import_ncore(Command import, const Globals& globals);

}  // namespace simuli::cli

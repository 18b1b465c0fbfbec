#pragma once
#include <charconv>
#include <cstddef>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/apps/cli/base/command.hpp"
#include "host/apps/cli/base/file_progress.hpp"
#include "host/apps/cli/base/refuse.hpp"
#include "host/apps/cli/info/info.hpp"
#include "io/import/points/point_grid.hpp"
#include "io/log/label_tracks.hpp"
#include "io/log/log.hpp"

namespace simuli::cli {

/// Adds a line on the labels left out, if there are any.
void add_label_line(const LabelReport& report, std::vector<std::string>& lines);

/// Prints `notes`, the lines on the recorded data, and then the log. Notes of an import are printed to stderr,
/// notes of a survey to stdout; the JSON output contains them as "notes", too.
void print_import(const Log& log, const std::vector<std::string>& notes, bool is_survey, bool json);

/// Adds --output and --survey. With --survey need_output() clears `output`; without either option it throws
/// Error{kUsage}.
inline void add_output(Command command, std::filesystem::path& output, bool& is_survey, const char* made) {
  command.option("-o,--output", output, fmt::format("{} folder to write; required without --survey", made));
  command.flag(
      "--survey", is_survey, "print the recorded data and which of them an import would use; write nothing");
}
void need_output(std::filesystem::path& output, bool is_survey);

/// Adds the options and the run function that all imports share. `run(options, progress, report)` returns the
/// log; with an empty options.output it returns the log that would be written. `describe(report)` returns lines
/// on the data that were imported and left out.
template <class Report, class Options, class Run, class Describe>
void add_run(Command command,
             const char* name,
             const std::shared_ptr<Options>& options,
             const Globals& globals,
             const Run& run,
             const Describe& describe) {
  const auto is_survey = std::make_shared<bool>(false);
  add_output(command, options->output, *is_survey, "log");
  command.run([=, &globals] {
    Options requested = *options;
    need_output(requested.output, *is_survey);
    FileProgress progress(std::string("import ") + name, globals);
    Report report;
    const Log log = run(requested, progress.callback(), report);
    progress.finish();
    std::vector<std::string> lines = describe(report);
    if constexpr (requires { report.labels; }) add_label_line(report.labels, lines);
    print_import(log, lines, *is_survey, globals.json);
  });
}

/// Adds --frames a:b, --first and --last.
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

/// Returns a line with the numbers of points and rays of clouds.
[[nodiscard]] std::string points_line(const PointReport& report);
/// Returns the numbers as runs: "3, 177 to 180"; runs after the tenth are replaced by "and more".
[[nodiscard]] std::string runs_text(const std::vector<std::size_t>& numbers);
/// Splits an option "FIRST=REST" or "FIRST:REST" at `at`; throws Error{kUsage} if a side is empty.
[[nodiscard]] std::pair<std::string, std::string> parted(const char* option,
                                                         const std::string& text,
                                                         char at,
                                                         const char* first = "TOPIC");
/// Returns the LiDAR `name` of --lidar; throws Error{kUsage} for a camera or a ray list.
[[nodiscard]] Lidar lidar_table(const std::string& name);

/// Adds `import mcap`: recordings of ROS 2.
void add_import_ros2(Command import, const Globals& globals);
/// Adds `import pandaset`: sequences of PandaSet.
void add_import_pandaset(Command import, const Globals& globals);
/// Adds `import ncore`: sequences of NVIDIA NCore.
void add_import_ncore(Command import, const Globals& globals);

}  // namespace simuli::cli

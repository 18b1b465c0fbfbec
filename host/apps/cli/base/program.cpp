#include "host/apps/cli/base/program.hpp"

#include <algorithm>
#include <cctype>
#include <exception>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iostream>
#include <new>
#include <system_error>

#include "host/apps/cli/base/crash.hpp"
#include "host/apps/cli/base/interrupt.hpp"
#include "host/apps/cli/base/refuse.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/one_line.hpp"
#include "host/core/base/stopwatch.hpp"
#include "host/core/base/version.hpp"
#include "host/device/runtime/device.hpp"
#include "host/device/runtime/disk_cache.hpp"

namespace simuli::cli {
namespace {

/// Returns the version in the first line, for programs; then the build and the default device.
std::string version_text(const std::string& built_from) {
  std::string device;
  try {
    const DeviceInfo info = Device::best().info();
    device = fmt::format("{}, driver {}", info.label(), info.driver_version);
  } catch (const Error& error) {
    device = fmt::format("none ({})", error.what());
  }
  return fmt::format("simuli {}{}\nbuild: {}\ndevice: {}", version(), built_from, SIMULI_BUILD, device);
}

}  // namespace

void add_globals(Command root, Globals& globals) {
  root.option("--device", globals.device, "part of the OpenCL device's name; default: the best one");
  const std::string names = fmt::format("{}", fmt::join(quality_names(), ", "));
  root.option(
          "--quality",
          [&globals, names](const std::string& name) {
            const auto quality = find_quality(name);
            if (!quality) {
              throw_usage_error("--quality", name, names);
            }
            globals.quality = *quality;
          },
          "trade-off of speed and accuracy in rendering: " + names)
      .shown_as("NAME", "balanced")
      .completed_by([] { return quality_names(); });
  root.flag("--json", globals.json, "data as JSON on stdout");
  root.flag("--json-progress", globals.json_progress, "progress as one JSON object a line on stderr");
  root.flag("--verbose", globals.verbose, "print times to stderr");
}

ProgressStyle progress_style(const Globals& globals) {
  if (globals.json_progress) return ProgressStyle::kJson;
  return globals.json ? ProgressStyle::kQuiet : simuli::progress_style();
}

std::vector<std::string> devices_of(const std::string& request) {
  std::vector<std::string> devices;
  for (std::size_t begin = 0; begin <= request.size();) {
    const std::size_t end = std::min(request.find(',', begin), request.size());
    devices.push_back(request.substr(begin, end - begin));
    begin = end + 1;
  }
  const bool are_numbers = std::all_of(devices.begin(), devices.end(), [](const std::string& device) {
    return !device.empty() &&
           std::all_of(device.begin(), device.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
  });
  return are_numbers ? devices : std::vector<std::string>{request};
}

void refuse_absent(const std::string& what, const std::string& option) {
  throw_usage_error(what, "a build without it", fmt::format("one with -D {}=ON", option));
}

void add_absent(Command app, const std::string& name, const std::string& help, const std::string& option) {
  const Command command = app.command(name, help);
  command.take_anything();
  command.run([name, option] { refuse_absent(name, option); });
}

void run_arguments(const std::string& name,
                   const std::string& about,
                   int argc,
                   const char* const* argv,
                   const AddCommands& add,
                   const std::string& commit) {
  const std::string built_from = commit.empty() ? "" : fmt::format(" ({})", commit);
  CommandLine line(name, about, [&built_from] { return version_text(built_from); });
  Globals globals;
  globals.commit = commit;
  add_globals(line.root(), globals);
  add(line, globals);
  const Stopwatch watch;
  const bool has_run = line.parse(argc, argv);  // false: only the requested help or version was printed
  if (!std::cout.flush()) {
    end_if_unread();
    throw_input_error(
        "stdout", "output", "a stream that cannot be written", "an open stream with free space");
  }
  if (has_run && globals.verbose) {
    std::cerr << fmt::format("simuli: {:.2f} s", watch.seconds()) << std::endl;
  }
}

Failure failure_of(const std::exception& thrown) {
  constexpr int kInternal = static_cast<int>(ErrorKind::kInternal);
  if (const auto* const error = dynamic_cast<const Error*>(&thrown))
    return {error->what(), error->exit_code()};
  if (const auto* const ended = dynamic_cast<const Ended*>(&thrown))
    return {ended->what(), ended->exit_code()};
  if (dynamic_cast<const Interrupted*>(&thrown) != nullptr) return {thrown.what(), kInterruptedExit};
  // For example, the working folder was removed; io converts most file system errors to Error.
  if (const auto* const file = dynamic_cast<const std::filesystem::filesystem_error*>(&thrown))
    return {on_one_line(fmt::format("found {}, allowed existing files and folders", file->what())),
            static_cast<int>(ErrorKind::kInput)};
  const auto* const system = dynamic_cast<const std::system_error*>(&thrown);
  // A thread could not be created because its stack needs memory; io reports file errors as Error.
  const bool has_no_thread = system != nullptr && system->code() == std::errc::resource_unavailable_try_again;
  if (has_no_thread || dynamic_cast<const std::bad_alloc*>(&thrown) != nullptr) {
    return {"out of memory", kMemoryExit};
  }
  return {on_one_line(fmt::format("internal error: {}", thrown.what())), kInternal};
}

int run_program(const std::string& name,
                const std::string& about,
                int argc,
                char** argv,
                const AddCommands& add,
                const std::string& commit) {
  watch_signals();
  watch_crashes();
  // Printed last, after all other output.
  struct Notes {
    ~Notes() {
      if (const std::string note = driver_cache_note(); !note.empty()) {
        std::cerr << "simuli: note: " << note << std::endl;
      }
    }
  } const notes;
  try {
    run_arguments(name, about, argc, argv, add, commit);
    return 0;
  } catch (const std::exception& thrown) {
    const Failure failure = failure_of(thrown);
    if (!failure.line.empty()) std::cerr << "simuli: " << failure.line << std::endl;
    return failure.exit_code;
  }
}

}  // namespace simuli::cli

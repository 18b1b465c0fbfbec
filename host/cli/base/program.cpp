#include "host/cli/base/program.hpp"

#include <exception>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iostream>
#include <new>
#include <system_error>

#include "host/base/error.hpp"
#include "host/base/one_line.hpp"
#include "host/base/stopwatch.hpp"
#include "host/base/version.hpp"
#include "host/cli/base/crash.hpp"
#include "host/cli/base/interrupt.hpp"
#include "host/runtime/cache/disk_cache.hpp"

namespace simuli::cli {
namespace {

void add_globals(Command root, Globals& globals) {
  root.option("--device", globals.device, "part of the OpenCL device's name; default: the best one");
  const std::string names = fmt::format("{}", fmt::join(quality_names(), ", "));
  root.option(
          "--quality",
          [&globals, names](const std::string& name) {
            const auto quality = find_quality(name);
            if (!quality) {
              throw Error(ErrorKind::kUsage, fmt::format("--quality: found {}, allowed {}", name, names));
            }
            globals.quality = *quality;
          },
          "speed against accuracy, wherever something is rendered: " + names)
      .shown_as("NAME", "balanced")
      .completed_by([] { return quality_names(); });
  root.flag("--json", globals.json, "data as JSON on stdout");
  root.flag("--json-progress", globals.json_progress, "progress as one JSON object a line on stderr");
  root.flag("--verbose", globals.verbose, "tell times on stderr");
}

int fail(const std::string& what, int exit_code) {
  std::cerr << "simuli: " << what << std::endl;
  return exit_code;
}

}  // namespace

ProgressStyle progress_style(const Globals& globals) {
  if (globals.json_progress) return ProgressStyle::kJson;
  return globals.json ? ProgressStyle::kQuiet : simuli::progress_style();
}

void refuse_absent(const std::string& what, const std::string& option) {
  throw Error(ErrorKind::kUsage,
              fmt::format("{}: found a build without it, allowed one with -D {}=ON", what, option));
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
  CommandLine line(name, about, fmt::format("simuli {}{}", version(), built_from));
  Globals globals;
  globals.commit = commit;
  add_globals(line.root(), globals);
  add(line, globals);
  const Stopwatch watch;
  const bool has_run = line.parse(argc, argv);  // or has told what was asked for
  if (!std::cout.flush()) throw Error(ErrorKind::kInput, "stdout: could not be written");
  if (has_run && globals.verbose) {
    std::cerr << fmt::format("simuli: {:.2f} s", watch.seconds()) << std::endl;
  }
}

int run_program(const std::string& name,
                const std::string& about,
                int argc,
                char** argv,
                const AddCommands& add,
                const std::string& commit) {
  constexpr int kInternal = static_cast<int>(ErrorKind::kInternal);
  watch_signals();
  watch_crashes();
  // Behind everything else, as the last thing to be read.
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
  } catch (const Error& error) {
    // A driver's build log has lines of its own.
    const bool is_log = error.kind() == ErrorKind::kKernel;
    return fail(is_log ? error.what() : on_one_line(error.what()), error.exit_code());
  } catch (const Interrupted& interrupted) {
    return fail(interrupted.what(), kInterruptedExit);
  } catch (const std::bad_alloc&) {
    return fail("out of memory", kMemoryExit);
  } catch (const std::system_error& error) {
    // Of threads, whose stacks take memory; what libraries say of files comes as an Error.
    if (error.code() == std::errc::resource_unavailable_try_again) return fail("out of memory", kMemoryExit);
    return fail(on_one_line(fmt::format("internal error: {}", error.what())), kInternal);
  } catch (const std::exception& error) {
    return fail(on_one_line(fmt::format("internal error: {}", error.what())), kInternal);
  }
}

}  // namespace simuli::cli

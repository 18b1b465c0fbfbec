#include <chrono>
#include <exception>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iostream>
#include <new>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/version.hpp"
#include "host/cli/base/commands.hpp"
#include "host/render/options/quality.hpp"

simuli::ProgressStyle simuli::cli::progress_style(const Globals& globals) {
  if (globals.json_progress) return ProgressStyle::kJson;
  return globals.json ? ProgressStyle::kQuiet : simuli::progress_style();
}

namespace {

void add_globals(CLI::App& app, simuli::cli::Globals& globals) {
  app.add_option("--device", globals.device, "part of the OpenCL device's name; default: the best one");
  const std::string names = fmt::format("{}", fmt::join(simuli::quality_names(), ", "));
  app.add_option_function<std::string>(
         "--quality",
         [&globals, names](const std::string& name) {
           const auto quality = simuli::find_quality(name);
           if (!quality) {
             throw simuli::Error(simuli::ErrorKind::kUsage,
                                 fmt::format("--quality: found {}, allowed {}", name, names));
           }
           globals.quality = *quality;
         },
         "speed against accuracy, wherever something is rendered: " + names)
      ->type_name("NAME")
      ->default_str("balanced")
      ->trigger_on_parse();
  app.add_flag("--json", globals.json, "data as JSON on stdout");
  app.add_flag("--json-progress", globals.json_progress, "progress as one JSON object a line on stderr");
  app.add_flag("--verbose", globals.verbose, "tell times on stderr");
}

int fail(const std::string& what, int exit_code) {
  std::cerr << "simuli: " << what << std::endl;
  return exit_code;
}

int run(int argc, char** argv) {
  using simuli::ErrorKind;
  CLI::App app("Camera and LiDAR simulation with 3D Gaussians on any OpenCL device", "simuli");
  app.set_version_flag("--version", std::string("simuli ") + simuli::version());
  app.require_subcommand(1);
  app.fallthrough();  // global options may stand behind the command's name
  simuli::cli::Globals globals;
  add_globals(app, globals);
  simuli::cli::add_align(app, globals);
  simuli::cli::add_bench(app, globals);
  simuli::cli::add_convert(app, globals);
  simuli::cli::add_demo(app, globals);
  simuli::cli::add_devices(app, globals);
  simuli::cli::add_eval(app, globals);
  simuli::cli::add_fit(app, globals);
  simuli::cli::add_import(app, globals);
  simuli::cli::add_info(app, globals);
  simuli::cli::add_render(app, globals);
  simuli::cli::add_synth(app, globals);
  simuli::cli::add_tile(app, globals);
  simuli::cli::add_train(app, globals);
  simuli::cli::add_view(app, globals);

  const auto begin = std::chrono::steady_clock::now();
  try {
    app.parse(argc, argv);  // runs the command
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    // CLI11 names a missing command before it names an unknown one.
    const std::vector<std::string> unknown = app.remaining(true);
    const bool is_unknown = error.get_name() == "RequiredError" && !unknown.empty();
    const std::string what =
        is_unknown ? "found \"" + unknown.front() + "\", allowed a command" : error.what();
    return fail(what + " (simuli --help)", static_cast<int>(ErrorKind::kUsage));
  }
  if (!std::cout.flush()) return fail("stdout: could not be written", static_cast<int>(ErrorKind::kInput));
  if (globals.verbose) {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
    std::cerr << fmt::format("simuli: {:.2f} s", elapsed.count()) << std::endl;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  constexpr int kInternal = static_cast<int>(simuli::ErrorKind::kInternal);
  try {
    return run(argc, argv);
  } catch (const simuli::Error& error) {
    return fail(error.what(), error.exit_code());
  } catch (const std::bad_alloc&) {
    return fail("out of memory", kInternal);
  } catch (const std::exception& error) {
    return fail(fmt::format("internal error: {}", error.what()), kInternal);
  }
}

#pragma once
// The commands of the program, one file each. A command adds itself to the app; its callback does the work
// and throws Error, which main() turns into one line on stderr and an exit code. Data goes to stdout,
// everything else to stderr.
#include <CLI/CLI.hpp>
#include <string>

#include "host/cli/base/progress.hpp"
#include "host/render/options/quality.hpp"

namespace simuli::cli {

/// Options that every command takes, before or behind its name.
struct Globals {
  std::string device;                    // part of an OpenCL device's name; empty: the best one
  Quality quality = Quality::kBalanced;  // what --set starts from
  bool json = false;                     // data as JSON
  bool json_progress = false;            // progress as JSON lines
  bool verbose = false;                  // tell times on stderr
};

/// As asked for; nothing beside data as JSON.
[[nodiscard]] ProgressStyle progress_style(const Globals& globals);

void add_align(CLI::App& app, const Globals& globals);
void add_bench(CLI::App& app, const Globals& globals);
void add_convert(CLI::App& app, const Globals& globals);
void add_demo(CLI::App& app, const Globals& globals);
void add_devices(CLI::App& app, const Globals& globals);
void add_eval(CLI::App& app, const Globals& globals);
void add_fit(CLI::App& app, const Globals& globals);
void add_import(CLI::App& app, const Globals& globals);
void add_info(CLI::App& app, const Globals& globals);
void add_render(CLI::App& app, const Globals& globals);
void add_synth(CLI::App& app, const Globals& globals);
void add_tile(CLI::App& app, const Globals& globals);
void add_train(CLI::App& app, const Globals& globals);
void add_view(CLI::App& app, const Globals& globals);

}  // namespace simuli::cli

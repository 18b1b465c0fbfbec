#pragma once
// The commands of the program, one file each. A command adds itself to the program; what it runs does the
// work and throws Error, which run_program() turns into one line on stderr and an exit code. Data goes to
// stdout, everything else to stderr.
#include <string>
#include <vector>

#include "host/apps/cli/base/command.hpp"
#include "host/apps/cli/base/progress.hpp"
#include "host/device/render/options/quality.hpp"

namespace simuli::cli {

/// Options that every command takes, before or behind its name.
struct Globals {
  std::string device;                    // part of an OpenCL device's name; empty: the best one
  Quality quality = Quality::kBalanced;  // what --set starts from
  bool json = false;                     // data as JSON
  bool json_progress = false;            // progress as JSON lines
  bool verbose = false;                  // tell times on stderr
  std::string commit;                    // that the program was built from; may be empty
};

/// Of --device: "0,2" are two of them, anything else is one.
[[nodiscard]] std::vector<std::string> devices_of(const std::string& request);

/// As asked for; nothing beside data as JSON.
[[nodiscard]] ProgressStyle progress_style(const Globals& globals);

/// Error{kUsage}: `what` needs a build with that CMake option.
[[noreturn]] void refuse_absent(const std::string& what, const std::string& option);
/// A command that this build lacks: it refuses, whatever its arguments.
void add_absent(Command app, const std::string& name, const std::string& help, const std::string& option);

void add_actors(Command app, const Globals& globals);
void add_align(Command app, const Globals& globals);
void add_bench(CommandLine& line);
void add_completion(CommandLine& line);
void add_demo(Command app, const Globals& globals);
void add_devices(Command app, const Globals& globals);
void add_eval(Command app, const Globals& globals);
void add_export(Command app, const Globals& globals);
void add_fit(Command app, const Globals& globals);
void add_import(Command app, const Globals& globals);
void add_info(Command app, const Globals& globals);
void add_manual(CommandLine& line);
void add_mask(Command app, const Globals& globals);
void add_render(Command app, const Globals& globals);
void add_serve(Command app, const Globals& globals);
void add_synth(Command app, const Globals& globals);
void add_train(Command app, const Globals& globals);
void add_view(Command app, const Globals& globals);

}  // namespace simuli::cli

#pragma once
// Commands of the program, one file each. A command adds itself to the program. Its function throws Error,
// which run_program() converts to one line on stderr and an exit code. Data are written to stdout, everything
// else to stderr.
#include <string>
#include <vector>

#include "host/apps/cli/base/command.hpp"
#include "host/apps/cli/base/progress.hpp"
#include "host/device/render/options/quality.hpp"

namespace simuli::cli {

/// Options of every command, before or after its name.
struct Globals {
  std::string device;                    // part of the name of an OpenCL device; empty: the best device
  Quality quality = Quality::kBalanced;  // base of the settings of --set
  bool json = false;                     // print data as JSON
  bool json_progress = false;            // print progress as JSON lines
  bool verbose = false;                  // print times to stderr
  std::string commit;                    // commit of the build; may be empty
};

/// Splits the value of --device: "0,2" are two devices, any other text is one.
[[nodiscard]] std::vector<std::string> devices_of(const std::string& request);

/// Returns the requested style; kQuiet for data as JSON.
[[nodiscard]] ProgressStyle progress_style(const Globals& globals);

/// Throws Error{kUsage}: `what` needs a build with the CMake option `option`.
[[noreturn]] void refuse_absent(const std::string& what, const std::string& option);
/// Adds a command that this build lacks: the command throws Error{kUsage} for any arguments.
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

#pragma once
// What the programs of this project share: global options, errors as one line on stderr and an exit code.
#include <functional>
#include <string>

#include "host/cli/base/commands.hpp"

namespace simuli::cli {

/// Adds the commands of a program; `globals` outlives them.
using AddCommands = std::function<void(CommandLine& line, const Globals& globals)>;

/// Reads the arguments and runs the command they name; throws what that throws, Error{kUsage} for arguments
/// that are not allowed. `name` as in CommandLine; a `commit` stands behind the version.
void run_arguments(const std::string& name,
                   const std::string& about,
                   int argc,
                   const char* const* argv,
                   const AddCommands& add,
                   const std::string& commit = "");

/// What main() does: reads the arguments, runs the command they name and returns the exit code.
[[nodiscard]] int run_program(const std::string& name,
                              const std::string& about,
                              int argc,
                              char** argv,
                              const AddCommands& add,
                              const std::string& commit = "");

}  // namespace simuli::cli

#pragma once
// Common parts of the project's programs: global options, errors as one line on stderr, exit codes.
#include <exception>
#include <functional>
#include <stdexcept>
#include <string>

#include "host/apps/cli/base/commands.hpp"

namespace simuli::cli {

/// Adds the commands of a program; `globals` outlives them.
using AddCommands = std::function<void(CommandLine& line, const Globals& globals)>;

/// Adds the options of every command, which set `globals`; `globals` must outlive the command line.
void add_globals(Command root, Globals& globals);

/// Parses the arguments and runs the selected command. Throws Error{kUsage} for arguments that are not
/// allowed, and all exceptions of the command. `name` as in CommandLine; `commit` is printed after the
/// version.
void run_arguments(const std::string& name,
                   const std::string& about,
                   int argc,
                   const char* const* argv,
                   const AddCommands& add,
                   const std::string& commit = "");

/// Thrown by a command that only has to end with an exit code. what() is a line for stderr; empty: no line.
class Ended : public std::runtime_error {
 public:
  Ended(int exit_code, const std::string& line) : std::runtime_error(line), exit_code_(exit_code) {}
  [[nodiscard]] int exit_code() const noexcept { return exit_code_; }

 private:
  int exit_code_;
};

/// Line and exit code for an exception of a command.
struct Failure {
  std::string line;
  int exit_code = 0;
};
[[nodiscard]] Failure failure_of(const std::exception& thrown);

/// Implements main(): parses the arguments, runs the selected command and returns the exit code.
[[nodiscard]] int run_program(const std::string& name,
                              const std::string& about,
                              int argc,
                              char** argv,
                              const AddCommands& add,
                              const std::string& commit = "");

}  // namespace simuli::cli

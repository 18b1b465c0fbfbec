#pragma once
// What the programs of this project share: global options, errors as one line on stderr and an exit code.
#include <exception>
#include <functional>
#include <stdexcept>
#include <string>

#include "host/apps/cli/base/commands.hpp"

namespace simuli::cli {

/// Adds the commands of a program; `globals` outlives them.
using AddCommands = std::function<void(CommandLine& line, const Globals& globals)>;

/// The options of every command, which set `globals`; it outlives them.
void add_globals(Command root, Globals& globals);

/// Reads the arguments and runs the command they name; throws what that throws, Error{kUsage} for arguments
/// that are not allowed. `name` as in CommandLine; a `commit` stands behind the version.
void run_arguments(const std::string& name,
                   const std::string& about,
                   int argc,
                   const char* const* argv,
                   const AddCommands& add,
                   const std::string& commit = "");

/// Leaves a command that has told all but how it ended: what() is the line on stderr, empty for none.
class Ended : public std::runtime_error {
 public:
  Ended(int exit_code, const std::string& line) : std::runtime_error(line), exit_code_(exit_code) {}
  [[nodiscard]] int exit_code() const noexcept { return exit_code_; }

 private:
  int exit_code_;
};

/// What is said of an exception that left a command, and the exit code of it.
struct Failure {
  std::string line;
  int exit_code = 0;
};
[[nodiscard]] Failure failure_of(const std::exception& thrown);

/// What main() does: reads the arguments, runs the command they name and returns the exit code.
[[nodiscard]] int run_program(const std::string& name,
                              const std::string& about,
                              int argc,
                              char** argv,
                              const AddCommands& add,
                              const std::string& commit = "");

}  // namespace simuli::cli

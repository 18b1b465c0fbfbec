#pragma once
// The program's commands and options as bash and man read them, from the descriptions that make the help.
#include <functional>
#include <string>
#include <vector>

#include "host/apps/cli/base/command.hpp"

namespace simuli::cli {

/// A script that completes the program's name, commands, options and values, for bash to read.
[[nodiscard]] std::string bash_completion(const CommandText& program);
/// Section 1, in the macros of man(7); `version` as --version tells it.
[[nodiscard]] std::string man_page(const CommandText& program, const std::string& version);

/// Calls `visit("program command ...", command)` of the program and of each command, outer ones first.
void visit_commands(const CommandText& program,
                    const std::function<void(const std::string& path, const CommandText& command)>& visit);

}  // namespace simuli::cli

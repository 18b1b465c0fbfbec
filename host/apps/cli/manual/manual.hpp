#pragma once
// Generates bash completion and the man page from the descriptions of the commands.
#include <functional>
#include <string>
#include <vector>

#include "host/apps/cli/base/command.hpp"

namespace simuli::cli {

/// Returns a bash script that completes the program's name, commands, options and values.
[[nodiscard]] std::string bash_completion(const CommandText& program);
/// Returns a page of section 1 with the macros of man(7); `version` as printed by --version.
[[nodiscard]] std::string man_page(const CommandText& program, const std::string& version);

/// Calls `visit("program command ...", command)` for the program and each command, parents first.
void visit_commands(const CommandText& program,
                    const std::function<void(const std::string& path, const CommandText& command)>& visit);

}  // namespace simuli::cli

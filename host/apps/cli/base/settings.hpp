#pragma once
// Option "--set KEY=VALUE" of commands.
#include <functional>
#include <string>
#include <vector>

#include "host/apps/cli/base/commands.hpp"
#include "host/core/base/fields.hpp"

namespace simuli::cli {

/// Adds "--set", whose values are appended to `settings`, for Fields::apply(). "--set help" prints the fields
/// of `fields` with the values that would be used, and requires no other argument.
void add_settings(Command command,
                  std::vector<std::string>& settings,
                  const Globals& globals,
                  std::function<Fields()> fields,
                  const std::string& help);

}  // namespace simuli::cli

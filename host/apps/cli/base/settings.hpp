#pragma once
// "--set KEY=VALUE" of commands.
#include <functional>
#include <string>
#include <vector>

#include "host/apps/cli/base/commands.hpp"
#include "host/core/base/fields.hpp"

namespace simuli::cli {

/// What users say of "--set" into `settings`, for Fields::apply(). "--set help" prints what `fields` makes,
/// with the values that would be used, and nothing else is asked of the command line.
void add_settings(Command command,
                  std::vector<std::string>& settings,
                  const Globals& globals,
                  std::function<Fields()> fields,
                  const std::string& help);

}  // namespace simuli::cli

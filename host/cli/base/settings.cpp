#include "host/cli/base/settings.hpp"

#include <iostream>
#include <utility>

#include "io/base/fields_json.hpp"

namespace simuli::cli {

void add_settings(Command command,
                  std::vector<std::string>& settings,
                  const Globals& globals,
                  std::function<Fields()> fields,
                  const std::string& help) {
  command.option("--set", settings, help).answers("help", [&globals, fields = std::move(fields)] {
    std::cout << (globals.json ? help_json(fields()).dump(2) + '\n' : fields().help());
  });
}

}  // namespace simuli::cli

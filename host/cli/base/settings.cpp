#include "host/cli/base/settings.hpp"

#include <iostream>
#include <utility>

#include "host/cli/base/json_text.hpp"
#include "io/base/fields_json.hpp"

namespace simuli::cli {

void add_settings(Command command,
                  std::vector<std::string>& settings,
                  const Globals& globals,
                  std::function<Fields()> fields,
                  const std::string& help) {
  command.option("--set", settings, help).answers("help", [&globals, fields = std::move(fields)] {
    std::cout << (globals.json ? json_text(help_json(fields())) + '\n' : fields().help());
  });
}

}  // namespace simuli::cli

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
  command.option("--set", settings, help)
      .answers("help",
               [&globals, fields] {
                 std::cout << (globals.json ? json_text(help_json(fields())) + '\n' : fields().help());
               })
      .completed_by([fields = std::move(fields)] {
        std::vector<std::string> keys{"help"};
        const Fields all = fields();
        for (const Field& field : all.all()) keys.push_back(field.key + '=');
        return keys;
      });
}

}  // namespace simuli::cli

#include "host/apps/cli/base/settings.hpp"

#include <fmt/format.h>
#include <iostream>
#include <set>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include "host/apps/cli/base/json_text.hpp"
#include "io/base/json_reader.hpp"

namespace simuli::cli {
namespace {

/// Returns the content of Fields::help() as [{"group", "key", "default", "allowed", "help"}...].
Json help_json(const Fields& fields) {
  Json rows = Json::array();
  for (const Field& field : fields.all()) {
    const Json preset = std::visit(
        [&](const auto& value) -> Json {
          if constexpr (std::is_same_v<decltype(value), const EnumValue&>) {
            return field.text();
          } else {
            return *value;
          }
        },
        field.value);
    rows.push_back({{"group", field.group},
                    {"key", field.key},
                    {"default", preset},
                    {"allowed", field.allowed()},
                    {"help", field.help}});
  }
  return rows;
}

}  // namespace

void add_settings(Command command,
                  std::vector<std::string>& settings,
                  const Globals& globals,
                  std::function<Fields()> fields,
                  const std::string& help) {
  command.option("--set", settings, help)
      .on_each([reported = std::set<std::string>()](const std::string& setting) mutable {
        const std::string key = setting.substr(0, setting.find('=')), current = Fields::current_key(key);
        if (key == current || !reported.insert(key).second) return;
        std::cerr << fmt::format("simuli: --set {} is now called {}\n", key, current);
      })
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

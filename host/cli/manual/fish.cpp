#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/cli/manual/manual.hpp"

namespace simuli::cli {
namespace {

/// In fish's single quotes a backslash stands for itself but before a quote or another one.
std::string in_quotes(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') out += '\\';
    out += c;
  }
  return out + "'";
}

std::string option_line(const std::string& start, const OptionText& option) {
  std::string line = start;
  for (const std::string& name : option.names) {
    if (option.is_named) line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  }
  const std::string words = fmt::format("{}", fmt::join(option.completions, " "));
  if (!words.empty()) line += (option.is_named ? " -x -a " : " -a ") + in_quotes(words);
  if (words.empty() && !option.is_flag) line += " -r -F";
  return line + " -d " + in_quotes(option.help) + '\n';
}

}  // namespace

std::string fish_completion(const CommandText& program) {
  std::string cases, lines;
  visit_commands(program, [&](const std::string& path, const CommandText& command) {
    const bool is_program = path == program.name;
    const std::string everywhere = fmt::format("complete -c {}", program.name);
    const std::string here = fmt::format(
        "{} -n {}", everywhere, in_quotes(fmt::format("test (__{}_command) = \"{}\"", program.name, path)));
    if (!is_program) cases += ' ' + in_quotes(path);
    for (const CommandText& inner : command.commands) {
      lines += fmt::format("{} -f -a {} -d {}\n", here, inner.name, in_quotes(inner.help));
    }
    for (const OptionText& option : command.options) {
      if (option.is_named || !option.completions.empty()) {
        lines += option_line(is_program ? everywhere : here, option);
      }
    }
  });
  return fmt::format(R"(# Completion of {name} for fish, made by "{name} completion fish".
function __{name}_command
    set -l command {name}
    for word in (commandline -opc)[2..-1]
        switch "$command $word"
            case{cases}
                set command "$command $word"
        end
    end
    echo $command
end
)",
                     fmt::arg("name", program.name),
                     fmt::arg("cases", cases)) +
         lines;
}

}  // namespace simuli::cli

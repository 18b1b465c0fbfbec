#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/cli/base/quoted.hpp"
#include "host/cli/manual/manual.hpp"

namespace simuli::cli {
namespace {

/// "simuli import" -> "__simuli_import".
std::string function_name(const std::string& path) {
  std::string name = "__" + path;
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

/// With a backslash before what parts the fields of a specification.
std::string field(const std::string& text, const std::string& marks) {
  std::string out;
  for (const char c : text) {
    if (marks.find(c) != std::string::npos) out += '\\';
    out += c;
  }
  return out;
}

std::string values(const OptionText& option) {
  if (option.completions.empty()) return "_files";
  std::string words;
  for (const std::string& word : option.completions)
    words += fmt::format("{}{}", words.empty() ? "" : " ", field(word, "=:()"));
  return "(" + words + ")";
}

std::string specification(const OptionText& option) {
  const std::string help = field(option.help, "[]:\\");
  if (!option.is_named) {
    const std::string all = option.completions.empty() ? "_files" : values(option);
    return quoted(fmt::format(":{}:{}", field(option.names.front(), ":"), all));
  }
  std::string names = fmt::format("{}", fmt::join(option.names, ","));
  std::string text =
      option.names.size() > 1 ? fmt::format("'({})'{{{}}}", fmt::join(option.names, " "), names) : names;
  if (option.takes_many) text = option.names.size() > 1 ? text : "'*'" + names;
  text += quoted("[" + help + "]" + (option.is_flag ? "" : ":value:" + values(option)));
  return text;
}

}  // namespace

std::string zsh_completion(const CommandText& program) {
  std::string shared, functions;
  for (const OptionText& option : program.options) {
    if (option.is_named) shared += "    " + specification(option) + "\n";
  }
  visit_commands(program, [&](const std::string& path, const CommandText& command) {
    std::string body = "  _arguments -C $shared";
    for (const OptionText& option : command.options) {
      if (path != program.name) body += " \\\n    " + specification(option);
    }
    if (!command.commands.empty()) body += " \\\n    '1: :->command' '*:: :->rest'";
    body += '\n';
    if (!command.commands.empty()) {
      std::string commands, cases;
      for (const CommandText& inner : command.commands) {
        commands += "\n      " + quoted(inner.name + ":" + field(inner.help, ":\\"));
        cases += fmt::format("    {}) {} ;;\n", inner.name, function_name(path + ' ' + inner.name));
      }
      body += fmt::format(
          "  case $state in\n  command)\n    local -a commands=({}\n    )\n    _describe command commands "
          ";;\n"
          "  rest)\n    case $line[1] in\n{}    esac ;;\n  esac\n",
          commands,
          cases);
    }
    functions += fmt::format("{}() {{\n  local state line\n{}}}\n", function_name(path), body);
  });
  // As a file of a folder in fpath it is the body of _NAME, which is called whenever something is completed.
  return fmt::format(
      "#compdef {0}\n# Completion of {0} for zsh, made by \"{0} completion zsh\".\n"
      "{1}_{0}() {{\n  local curcontext=\"$curcontext\"\n  local -a shared=(\n{2}  )\n  __{0}\n}}\n"
      "if [[ $funcstack[1] == _{0} ]]; then _{0}; else compdef _{0} {0}; fi\n",
      program.name,
      functions,
      shared);
}

}  // namespace simuli::cli

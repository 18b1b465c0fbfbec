#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/apps/cli/manual/manual.hpp"

namespace simuli::cli {
namespace {

/// Returns a line of text without requests to the typesetter.
std::string line_of(const std::string& text) {
  std::string out = text.starts_with('.') || text.starts_with('\'') ? "\\&" : "";
  for (const char c : text) {
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else {
      out += c;
    }
  }
  return out + '\n';
}

/// Returns "-o, --output TEXT" and the help below it.
std::string entry(const OptionText& option) {
  std::string head = fmt::format("{}", fmt::join(option.names, ", "));
  if (!option.is_flag && option.is_named) head += ' ' + option.type + (option.takes_many ? " ..." : "");
  std::string help = option.help;
  if (!option.preset.empty()) help += fmt::format(" (default: {})", option.preset);
  if (option.is_required) help += " (required)";
  return ".TP\n.B " + line_of(head) + line_of(help);
}

std::string entries(const CommandText& command) {
  std::string text;
  for (const bool named : {false, true}) {
    for (const OptionText& option : command.options) {
      if (option.is_named == named && option.names.front() != "--help") text += entry(option);
    }
  }
  return text;
}

/// Returns the usage line of a command.
std::string usage(const std::string& path, const CommandText& command) {
  std::string text = path;
  if (!command.commands.empty()) return text + " COMMAND ...";
  for (const OptionText& option : command.options) {
    if (!option.is_named) text += ' ' + (option.is_required ? option.names[0] : '[' + option.names[0] + ']');
  }
  for (const OptionText& option : command.options) {
    if (option.is_named && option.is_required) text += ' ' + option.names.back() + ' ' + option.type;
  }
  return text + " [OPTIONS]";
}

}  // namespace

std::string man_page(const CommandText& program, const std::string& version) {
  std::string text = fmt::format(".TH {} 1 \"\" \"{}\"\n.SH NAME\n", program.name, version);
  text += line_of(program.name + " - " + program.help);
  text += ".SH SYNOPSIS\n" + line_of(usage(program.name, program));
  text += ".SH OPTIONS\nBefore or after the name of any command.\n" + entries(program);
  text +=
      ".TP\n.B \\-\\-help\nprints the help of the program, or after a command's name the help of the "
      "command\n.SH COMMANDS\n";
  visit_commands(program, [&](const std::string& path, const CommandText& command) {
    if (path == program.name) return;
    text += ".SS " + line_of(usage(path, command)) + line_of(command.help) + entries(command);
  });
  return text +
         ".SH EXIT STATUS\n0 done, 2 usage, 3 input, 4 device, 5 kernel, 6 numeric, 70 internal;\n"
         "75 interrupted after a checkpoint was written.\n"
         "Errors are one line on stderr: file or option, field, found value, allowed value.\n";
}

}  // namespace simuli::cli

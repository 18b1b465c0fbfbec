#include "host/device/runtime/declaration.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <fmt/format.h>

#include "host/core/base/error.hpp"

namespace simuli {
namespace {

/// Returns `text` with comments and preprocessor lines replaced by a space or a line end.
std::string plain(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  bool line_starts = true;
  for (std::size_t i = 0; i < text.size();) {
    const std::string_view rest = text.substr(i);
    if (rest.starts_with("//") || (line_starts && rest.starts_with('#'))) {
      std::size_t end = rest.find('\n');
      while (end != std::string_view::npos && rest[end - 1] == '\\') end = rest.find('\n', end + 1);
      i += std::min(end, rest.size());
    } else if (rest.starts_with("/*")) {
      const std::size_t end = rest.find("*/", 2);
      i += end == std::string_view::npos ? rest.size() : end + 2;
      out += ' ';
    } else {
      line_starts =
          rest[0] == '\n' || (line_starts && std::isspace(static_cast<unsigned char>(rest[0])) != 0);
      out += rest[0];
      ++i;
    }
  }
  return out;
}

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

/// Returns the word or the single other character at `at` and advances `at`; empty at the end of the text.
std::string_view next_token(std::string_view text, std::size_t& at) {
  while (at < text.size() && std::isspace(static_cast<unsigned char>(text[at])) != 0) ++at;
  const std::size_t begin = at;
  while (at < text.size() && is_word(text[at])) ++at;
  if (at == begin && at < text.size()) ++at;
  return text.substr(begin, at - begin);
}

/// Returns the position after the bracket that closes the bracket before `at`.
std::size_t behind_bracket(std::string_view text, std::size_t at) {
  for (int open = 1; at < text.size() && open > 0; ++at)
    open += text[at] == '(' ? 1 : text[at] == ')' ? -1 : 0;
  return at;
}

constexpr std::array<std::string_view, 7> kNotOfTheType = {
    "restrict", "__restrict", "volatile", "struct", "private", "__private", "unsigned"};

/// Parses the words between two commas: "__global const real* params".
ArgumentDeclaration argument_of(std::string_view text) {
  ArgumentDeclaration argument;
  std::string stars;
  bool is_unsigned = false;
  std::size_t at = 0;
  for (std::string_view token = next_token(text, at); !token.empty(); token = next_token(text, at)) {
    if (token == "*") {
      stars += '*';
    } else if (token == "const") {
      argument.is_const = argument.is_const || stars.empty();
    } else if (token == "__global" || token == "global" || token == "__constant" || token == "constant") {
      argument.space = ArgumentSpace::kGlobal;
      argument.is_const = argument.is_const || token.ends_with("constant");
    } else if (token == "__local" || token == "local") {
      argument.space = ArgumentSpace::kLocal;
    } else if (std::find(kNotOfTheType.begin(), kNotOfTheType.end(), token) != kNotOfTheType.end()) {
      is_unsigned = is_unsigned || token == "unsigned";
    } else if (argument.type.empty()) {
      argument.type = fmt::format("{}{}", is_unsigned ? "u" : "", token);
    } else {
      argument.name = token;
    }
  }
  argument.type += stars;
  return argument;
}

KernelDeclaration arguments_of(std::string_view list) {
  KernelDeclaration arguments;
  while (!list.empty()) {
    const std::size_t comma = std::min(list.find(','), list.size());
    ArgumentDeclaration argument = argument_of(list.substr(0, comma));
    if (!argument.name.empty()) arguments.push_back(std::move(argument));
    list.remove_prefix(std::min(comma + 1, list.size()));
  }
  return arguments;
}

}  // namespace

std::map<std::string, KernelDeclaration> kernel_declarations(std::string_view text) {
  std::map<std::string, KernelDeclaration> kernels;
  const std::string code = plain(text);
  std::size_t at = 0;
  for (std::string_view token = next_token(code, at); !token.empty(); token = next_token(code, at)) {
    if (token != "__kernel" && token != "kernel") continue;
    std::string name;
    for (token = next_token(code, at); !token.empty() && token != "{"; token = next_token(code, at)) {
      if (token == "__attribute__") {
        static_cast<void>(next_token(code, at));
        at = behind_bracket(code, at);
      } else if (token == "(") {
        const std::size_t end = behind_bracket(code, at);
        const std::string_view list = std::string_view(code).substr(at, end - at - 1);
        if (!kernels.emplace(name, arguments_of(list)).second) {
          throw Error(ErrorKind::kKernel, "kernel " + name + " is declared twice");
        }
        at = end;
        break;
      } else {
        name = token;
      }
    }
  }
  return kernels;
}

}  // namespace simuli

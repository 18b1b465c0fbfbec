#include "host/device/runtime/build_options.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include "host/core/base/error.hpp"

namespace simuli {
namespace {

constexpr std::string_view kRealDouble = "SIMULI_REAL_DOUBLE";

// Not <cctype>, which depends on the locale; the compiler does not.
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_in_word(char c) { return is_letter(c) || (c >= '0' && c <= '9'); }

bool is_identifier(std::string_view name) {
  return !name.empty() && is_letter(name.front()) && std::all_of(name.begin(), name.end(), is_in_word);
}

bool holds_word(std::string_view text, std::string_view word) {
  for (std::size_t at = text.find(word); at != std::string_view::npos; at = text.find(word, at + 1)) {
    const std::size_t end = at + word.size();
    const bool starts = at == 0 || !is_in_word(text[at - 1]);
    if (starts && (end == text.size() || !is_in_word(text[end]))) return true;
  }
  return false;
}

std::string without_comments(std::string_view source) {
  std::string code;
  while (!source.empty()) {
    const std::string_view line = source.substr(0, source.find('\n'));
    code.append(line.substr(0, line.find("//"))).append("\n");
    source.remove_prefix(std::min(line.size() + 1, source.size()));
  }
  return code;
}

}  // namespace

BuildOptions& BuildOptions::define_text(const std::string& name, std::string value) {
  if (!is_identifier(name) || name == kRealDouble) {
    throw Error(ErrorKind::kInternal, "build option '" + name + "' is no identifier, or set by real() alone");
  }
  defines_[name] = std::move(value);
  return *this;
}

BuildOptions& BuildOptions::real(Precision precision) {
  precision_ = precision;
  return *this;
}

BuildOptions BuildOptions::named_in(std::string_view source) const {
  BuildOptions out = *this;
  const std::string code = without_comments(source);
  std::erase_if(out.defines_, [&](const auto& define) { return !holds_word(code, define.first); });
  return out;
}

std::string BuildOptions::text() const {
  // Kernel checks the host's argument types against the argument info. Warnings are off: tests report them with
  // clang, and PoCL's compiler prints their number on stderr, many of them about vector calling conventions of
  // inlined calls.
  std::string text = "-cl-std=CL1.2 -cl-kernel-arg-info -w";
  const auto append = [&](std::string_view name, std::string_view value) {
    text.append(" -D ").append(name).append("=").append(value);
  };
  if (precision_ == Precision::kDouble) append(kRealDouble, "1");
  for (const auto& [name, value] : defines_) append(name, value);
  return text;
}

}  // namespace simuli

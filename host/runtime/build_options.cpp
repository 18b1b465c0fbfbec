#include "host/runtime/build_options.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include "host/base/error.hpp"

namespace simuli {
namespace {

constexpr std::string_view kRealDouble = "SIMULI_REAL_DOUBLE";

// By hand: <cctype> follows the locale, the compiler doesn't.
bool is_identifier(std::string_view name) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  return !name.empty() && is_letter(name.front()) &&
         std::all_of(name.begin(), name.end(), [&](char c) { return is_letter(c) || is_digit(c); });
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

std::string BuildOptions::text() const {
  // Argument info is what Kernel checks the host's types against.
  std::string text = "-cl-std=CL1.2 -cl-kernel-arg-info";
  const auto append = [&](std::string_view name, std::string_view value) {
    text.append(" -D ").append(name).append("=").append(value);
  };
  if (precision_ == Precision::kDouble) append(kRealDouble, "1");
  for (const auto& [name, value] : defines_) append(name, value);
  return text;
}

}  // namespace simuli

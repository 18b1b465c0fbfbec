#pragma once
// Words as shells read them.
#include <string>

namespace simuli::cli {

/// In quotes in which bash changes nothing.
[[nodiscard]] inline std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

}  // namespace simuli::cli

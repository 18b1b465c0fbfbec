#pragma once
#include <string>
#include <vector>

namespace simuli {

/// The parts of a text between the characters `at`: one more than there are of them, empty ones included.
[[nodiscard]] inline std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == at) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

}  // namespace simuli

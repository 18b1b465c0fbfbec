#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace simuli {

/// Splits a text at each character `at`, including empty parts.
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

/// Converts ASCII letters to lower case, in any locale.
[[nodiscard]] inline std::string lower(std::string_view text) {
  std::string out(text);
  for (char& letter : out) {
    if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
  }
  return out;
}

}  // namespace simuli

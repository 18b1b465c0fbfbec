#pragma once
// Words as shells read them.
#include <algorithm>
#include <string>
#include <string_view>

namespace simuli::cli {

/// In quotes in which bash changes nothing.
[[nodiscard]] inline std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

/// As a shell reads it back: in quotes where it has to be.
[[nodiscard]] inline std::string shell_word(const std::string& word) {
  const auto is_plain = [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') ||
           std::string_view("_-./:,@=+").find(c) != std::string_view::npos;
  };
  if (!word.empty() && std::all_of(word.begin(), word.end(), is_plain)) return word;
  return quoted(word);
}

}  // namespace simuli::cli

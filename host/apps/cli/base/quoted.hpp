#pragma once
// Quoting of words for shells.
#include <algorithm>
#include <string>
#include <string_view>

#include "host/core/base/one_line.hpp"

namespace simuli::cli {

/// Returns the text in single quotes, unchanged by bash.
[[nodiscard]] inline std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

/// Returns a word that bash reads back as `word`: quoted if necessary, with control characters escaped.
[[nodiscard]] inline std::string shell_word(const std::string& word) {
  const auto is_plain = [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') ||
           std::string_view("_-./:,@=+").find(c) != std::string_view::npos;
  };
  if (!word.empty() && std::all_of(word.begin(), word.end(), is_plain)) return word;
  if (on_one_line(word) == word) return quoted(word);
  std::string escaped;
  for (const char c : word) escaped += c == '\'' || c == '\\' ? std::string{'\\', c} : std::string(1, c);
  return "$'" + on_one_line(escaped) + "'";
}

}  // namespace simuli::cli

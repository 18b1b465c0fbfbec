#pragma once
// Words as shells read them.
#include <algorithm>
#include <string>
#include <string_view>

#include "host/core/base/one_line.hpp"

namespace simuli::cli {

/// In quotes in which bash changes nothing.
[[nodiscard]] inline std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

/// As bash reads it back: in quotes where it has to be, without what terminals would act on.
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

// Lines of words and numbers: lists, YAML, command lines, headers.
#include <algorithm>
#include <fmt/format.h>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/fuzz/mutate/mutate.hpp"

namespace simuli::test {
namespace {

/// [first, second) of what stands between these characters.
std::vector<std::pair<std::size_t, std::size_t>> pieces(const std::string& text, std::string_view between) {
  std::vector<std::pair<std::size_t, std::size_t>> out;
  for (std::size_t at = text.find_first_not_of(between); at != std::string::npos;) {
    const std::size_t end = std::min(text.find_first_of(between, at), text.size());
    out.emplace_back(at, end);
    at = text.find_first_not_of(between, end);
  }
  return out;
}

std::string number_text(Choice& choice) {
  const double edge = choice.edge();
  switch (choice.below(3)) {
    case 0:
      return fmt::format("{:.0f}", edge);
    case 1:
      return fmt::format("{:e}", edge);
    default:
      return fmt::format("{}", edge);
  }
}

}  // namespace

std::optional<std::string> mutated_text(const std::string& text, Choice& choice) {
  const bool by_line = choice.below(3) == 0;
  const auto parts = pieces(text, by_line ? "\n" : " \t\r\n,:=@");
  if (parts.empty()) return std::nullopt;
  const auto [at, end] = parts[choice.below(parts.size())];
  const auto [other_at, other_end] = parts[choice.below(parts.size())];
  const std::string here = text.substr(at, end - at), there = text.substr(other_at, other_end - other_at);
  std::string out = text;
  switch (choice.below(5)) {
    case 0:
      return out.replace(at, end - at, there);
    case 1:
      return out.insert(at, there + (by_line ? "\n" : text.substr(end, 1)));
    case 2:
      return out.erase(at, end - at + 1);
    case 3:
      return out.replace(at, end - at, number_text(choice));
    default:
      return out.replace(at, end - at, choice.change(here));
  }
}

}  // namespace simuli::test

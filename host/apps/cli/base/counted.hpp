#pragma once
#include <fmt/format.h>
#include <string>

namespace simuli::cli {

/// "1 picture", "0 pictures", "12 boxes" (`things` where an s is not enough).
template <class Count>
[[nodiscard]] std::string counted(Count count, const std::string& thing, const std::string& things = "") {
  if (count == 1) return "1 " + thing;
  return fmt::format("{} {}", count, things.empty() ? thing + 's' : things);
}

}  // namespace simuli::cli

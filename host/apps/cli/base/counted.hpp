#pragma once
#include <fmt/format.h>
#include <string>

namespace simuli::cli {

/// Returns "1 picture", "0 pictures", "12 boxes" (`things`: the plural if it is not `thing` with an s).
template <class Count>
[[nodiscard]] std::string counted(Count count, const std::string& thing, const std::string& things = "") {
  if (count == 1) return "1 " + thing;
  return fmt::format("{} {}", count, things.empty() ? thing + 's' : things);
}

}  // namespace simuli::cli

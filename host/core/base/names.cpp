#include "host/core/base/names.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/core/base/error.hpp"
#include "host/core/base/one_line.hpp"

namespace simuli {
namespace {

constexpr std::size_t kLongestName = 128;

/// Returns the bytes of a character at `at` that names may not contain; 0 for an allowed one.
std::size_t forbidden(std::string_view text, std::size_t at) {
  return text[at] == '/' || text[at] == '\\' ? 1 : unprintable(text, at);
}

bool is_name(std::string_view name) {
  if (name.empty() || name.size() > kLongestName || name.front() == '.') return false;
  for (std::size_t i = 0; i < name.size(); ++i) {
    if (forbidden(name, i) > 0) return false;
  }
  return true;
}

}  // namespace

void need_name(std::string_view name, std::string_view file, std::string_view field) {
  if (is_name(name)) return;
  throw_input_error(
      file,
      field,
      '"' + std::string(name.substr(0, kLongestName)) + (name.size() > kLongestName ? "\"..." : "\""),
      "a name: 1 to 128 bytes, no / and \\, no control characters, no dot in front");
}

std::string name_from(std::string_view text) {
  std::string name;
  for (std::size_t i = 0; i < text.size() && name.size() < kLongestName;) {
    const std::size_t bytes = forbidden(text, i);
    name += bytes > 0 ? '_' : text[i];
    i += std::max<std::size_t>(bytes, 1);
  }
  // Does not cut multi-byte characters.
  if (name.size() == kLongestName) {
    std::size_t end = name.size();
    while (end > 0 && (static_cast<unsigned char>(name[end - 1]) & 0xC0U) == 0x80U) --end;
    if (end > 0 && static_cast<unsigned char>(name[end - 1]) >= 0xC0U) name.resize(end - 1);
  }
  if (name.empty()) return "_";
  if (name.front() == '.') name.front() = '_';
  return name;
}

std::size_t index_of_name(std::string_view name,
                          const std::vector<std::string>& names,
                          std::string_view what) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  throw Error(ErrorKind::kUsage,
              fmt::format("{}: found \"{}\", allowed {}", what, name, fmt::join(names, ", ")));
}

}  // namespace simuli

#include "host/cli/render/numbers.hpp"

#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <system_error>

#include "host/base/error.hpp"

namespace simuli::cli {

void refuse(const std::string& what, const std::string& found, const std::string& allowed) {
  throw Error(ErrorKind::kUsage, fmt::format("{}: found \"{}\", allowed {}", what, found, allowed));
}

std::vector<double> parse_numbers(const char* option,
                                  const std::string& text,
                                  std::size_t count,
                                  char separator) {
  std::vector<double> values;
  const char* at = text.data();
  const char* end = at + text.size();
  while (values.size() < count) {
    double value = 0.0;
    const auto result = std::from_chars(at, end, value);
    if (result.ec != std::errc{} || !std::isfinite(value)) break;
    values.push_back(value);
    at = result.ptr;
    if (values.size() == count && at == end) return values;
    if (at == end || *at != separator) break;
    ++at;
  }
  refuse(option, text, fmt::format("{} finite numbers parted by '{}'", count, separator));
}

}  // namespace simuli::cli

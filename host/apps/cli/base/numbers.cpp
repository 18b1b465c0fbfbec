#include "host/apps/cli/base/numbers.hpp"

#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <system_error>

#include "host/apps/cli/base/refuse.hpp"

namespace simuli::cli {

std::vector<double> parse_numbers(const char* option,
                                  const std::string& text,
                                  std::size_t count,
                                  char separator,
                                  const std::string& allowed) {
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
  refuse(option,
         text,
         allowed.empty() ? fmt::format("{} finite numbers separated by '{}'", count, separator) : allowed);
}

}  // namespace simuli::cli

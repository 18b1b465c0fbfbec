#include "host/apps/cli/base/refuse.hpp"

#include <fmt/format.h>

#include "host/core/base/error.hpp"

namespace simuli::cli {

void throw_usage_error(std::string_view option, std::string_view found, std::string_view allowed) {
  throw Error(ErrorKind::kUsage, fmt::format("{}: found {}, allowed {}", option, found, allowed));
}

void refuse(std::string_view option, std::string_view value, std::string_view allowed) {
  throw_usage_error(option, fmt::format("\"{}\"", value), allowed);
}

}  // namespace simuli::cli

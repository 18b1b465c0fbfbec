#include "host/base/error.hpp"

#include <fmt/format.h>

namespace simuli {

void throw_input_error(std::string_view file,
                       std::string_view field,
                       std::string_view found,
                       std::string_view allowed) {
  throw Error(ErrorKind::kInput,
              fmt::format("{}: {}: found {}, allowed {}", file, field, found, allowed));
}

}  // namespace simuli

#include "host/base/error.hpp"

#include <fmt/format.h>

namespace simuli {
namespace {

/// Text of a file, on the one line of a message: control characters as \xHH.
std::string on_one_line(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20U || byte == 0x7FU) {
      out += fmt::format("\\x{:02x}", byte);
    } else {
      out += c;
    }
  }
  return out;
}

}  // namespace

void throw_input_error(std::string_view file,
                       std::string_view field,
                       std::string_view found,
                       std::string_view allowed) {
  throw Error(ErrorKind::kInput,
              on_one_line(fmt::format("{}: {}: found {}, allowed {}", file, field, found, allowed)));
}

}  // namespace simuli

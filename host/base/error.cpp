#include "host/base/error.hpp"

#include <fmt/format.h>

namespace simuli {
namespace {

/// Of each part of a message, which may be a file's own text.
constexpr std::size_t kLongestPart = 1000;

/// Text of a file, on the one line of a message: control characters as \xHH.
std::string on_one_line(std::string_view text) {
  std::string out;
  for (const char c : text.substr(0, kLongestPart)) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20U || byte == 0x7FU) {
      out += fmt::format("\\x{:02x}", byte);
    } else {
      out += c;
    }
  }
  if (text.size() > kLongestPart) out += "...";
  return out;
}

}  // namespace

void throw_input_error(std::string_view file,
                       std::string_view field,
                       std::string_view found,
                       std::string_view allowed) {
  throw Error(ErrorKind::kInput,
              fmt::format("{}: {}: found {}, allowed {}",
                          on_one_line(file),
                          on_one_line(field),
                          on_one_line(found),
                          on_one_line(allowed)));
}

}  // namespace simuli

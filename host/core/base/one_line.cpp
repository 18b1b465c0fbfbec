#include "host/core/base/one_line.hpp"

#include <fmt/format.h>

namespace simuli {

std::size_t unprintable(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  const unsigned first = byte(at), second = byte(at + 1), third = byte(at + 2);
  if (first < 0x20U || first == 0x7FU) return 1;
  if (first == 0xC2U && second >= 0x80U && second <= 0x9FU) return 2;
  if (first != 0xE2U) return 0;
  const bool turns =
      (second == 0x80U && (third == 0x8EU || third == 0x8FU || (third >= 0xA8U && third <= 0xAEU))) ||
      (second == 0x81U && third >= 0xA6U && third <= 0xA9U);
  return turns ? 3 : 0;
}

std::string on_one_line(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t bytes = unprintable(text, i);
    if (bytes == 0) out += text[i++];
    for (std::size_t k = 0; k < bytes; ++k, ++i) {
      out += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[i]));
    }
  }
  return out;
}

}  // namespace simuli

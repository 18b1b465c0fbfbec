#include "host/core/base/one_line.hpp"

#include <fmt/format.h>

namespace simuli {
namespace {

/// Returns the bytes of the UTF-8 character at `at` (RFC 3629); 0 if invalid.
std::size_t utf8_bytes(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  const unsigned first = byte(at), second = byte(at + 1);
  if (first < 0x80U) return 1;
  const std::size_t bytes = first < 0xC2U ? 0 : first < 0xE0U ? 2 : first < 0xF0U ? 3 : first < 0xF5U ? 4 : 0;
  // Rejects overlong encodings, UTF-16 surrogates, and values above U+10FFFF.
  const unsigned least = first == 0xE0U ? 0xA0U : first == 0xF0U ? 0x90U : 0x80U;
  const unsigned most = first == 0xEDU ? 0x9FU : first == 0xF4U ? 0x8FU : 0xBFU;
  if (second < least || second > most) return 0;
  for (std::size_t k = 2; k < bytes; ++k) {
    if (byte(at + k) < 0x80U || byte(at + k) > 0xBFU) return 0;
  }
  return bytes;
}

bool is_inside_character(std::string_view text, std::size_t at) {
  for (std::size_t back = 1; back < 4 && back <= at; ++back) {
    if (utf8_bytes(text, at - back) > back) return true;
  }
  return false;
}

}  // namespace

std::size_t unprintable(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  const unsigned first = byte(at), second = byte(at + 1), third = byte(at + 2);
  if (first < 0x20U || first == 0x7FU) return 1;
  if (utf8_bytes(text, at) == 0) return is_inside_character(text, at) ? 0 : 1;
  if (first == 0xC2U && second >= 0x80U && second <= 0x9FU) return 2;
  if (first == 0xEFU && second == 0xBBU && third == 0xBFU) return 3;
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

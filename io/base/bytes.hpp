#pragma once
// Little-endian encoding of numbers.
#include <cstdint>
#include <string>

namespace simuli {

/// Appends the lowest `bytes` bytes of `value`, least significant first.
inline void append_little_endian(std::string& to, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) to.push_back(static_cast<char>(value >> (8 * i) & 255U));
}

}  // namespace simuli

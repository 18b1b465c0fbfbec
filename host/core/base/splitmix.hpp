#pragma once
// Numbers that look drawn, from numbers: the same everywhere.
#include <cstdint>

namespace simuli {

/// By which the state of a generator grows from one number to the next.
inline constexpr std::uint64_t kSplitmixStep = 0x9E3779B97F4A7C15ULL;

/// splitmix64, of the state before its step: every bit of the input moves half of the output's.
[[nodiscard]] constexpr std::uint64_t splitmix(std::uint64_t x) {
  x += kSplitmixStep;
  x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27U)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31U);
}

/// In [0, 1), for a number of a stream of a seed.
[[nodiscard]] constexpr double drawn(std::uint64_t seed, std::uint64_t stream, std::uint64_t number) {
  const std::uint64_t bits = splitmix(seed * kSplitmixStep + (stream << 40U) + number);
  return static_cast<double>(bits >> 11U) * 0x1.0p-53;
}

}  // namespace simuli

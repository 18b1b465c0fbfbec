#pragma once
// Deterministic pseudo-random numbers by hashing, equal on all machines.
#include <cstdint>

namespace simuli {

/// Increment of the generator's state.
inline constexpr std::uint64_t kSplitmixStep = 0x9E3779B97F4A7C15ULL;

/// splitmix64 of a state before its increment: every input bit changes half of the output bits.
[[nodiscard]] constexpr std::uint64_t splitmix(std::uint64_t x) {
  x += kSplitmixStep;
  x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27U)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31U);
}

/// Returns a number in [0, 1) by seed, stream and index.
[[nodiscard]] constexpr double drawn(std::uint64_t seed, std::uint64_t stream, std::uint64_t number) {
  const std::uint64_t bits = splitmix(seed * kSplitmixStep + (stream << 40U) + number);
  return static_cast<double>(bits >> 11U) * 0x1.0p-53;
}

}  // namespace simuli

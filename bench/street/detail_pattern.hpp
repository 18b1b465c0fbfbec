#pragma once
// Building blocks of the detailed street's patterns.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "io/synth/street_pattern.hpp"

namespace simuli::street_pattern {

/// Returns a smooth step from 0 at `low` to 1 at `high`.
inline double ease(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

/// Returns the remaining contrast of a pattern with parts of size_m in pixels of footprint_m: 1 for parts
/// larger than pixels, 0 for parts of half the size. Unresolved patterns show their mean.
inline double fine(double size_m, double footprint_m) {
  return footprint_m <= 0.0 ? 1.0 : std::clamp(2.0 * size_m / footprint_m - 1.0, 0.0, 1.0);
}

/// Whether (u, v) is on a letter of the text: u in letters from the left end, v in [0, 1) from below. Letters
/// have 3 x 5 dots and a gap of one dot.
inline bool ink(std::string_view text, double u, double v) {
  struct Letter {
    char name;
    std::uint16_t rows;  // 5 x 3 bits, top left first
  };
  static constexpr std::array<Letter, 26> kLetters{
      {{'A', 025755}, {'B', 065656}, {'C', 034443}, {'E', 074647}, {'H', 055755}, {'I', 022222},
       {'K', 055655}, {'L', 044447}, {'M', 057755}, {'N', 065555}, {'O', 075557}, {'P', 065644},
       {'R', 065655}, {'S', 034216}, {'T', 072222}, {'U', 055557}, {'0', 025552}, {'1', 026227},
       {'2', 061247}, {'3', 061216}, {'4', 055711}, {'5', 074616}, {'6', 034757}, {'7', 071222},
       {'8', 025252}, {'9', 075716}}};
  if (!(u >= 0.0 && v >= 0.0 && v < 1.0) || u >= static_cast<double>(text.size())) return false;
  const char name = text[static_cast<std::size_t>(u)];
  const int column = static_cast<int>(4.0 * (u - std::floor(u))), row = 4 - static_cast<int>(5.0 * v);
  if (column > 2) return false;
  const auto* const letter =
      std::find_if(kLetters.begin(), kLetters.end(), [&](const Letter& l) { return l.name == name; });
  return letter != kLetters.end() && ((letter->rows >> (3 * (4 - row) + (2 - column))) & 1U) != 0;
}

}  // namespace simuli::street_pattern

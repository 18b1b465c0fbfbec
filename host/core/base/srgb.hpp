#pragma once
#include <algorithm>
#include <cmath>

namespace simuli {

/// The sRGB transfer function (IEC 61966-2-1), from encoded to linear values.
inline float linear_of(float encoded) {
  const float x = std::clamp(encoded, 0.0F, 1.0F);
  return x <= 0.04045F ? x / 12.92F : std::pow((x + 0.055F) / 1.055F, 2.4F);
}

}  // namespace simuli

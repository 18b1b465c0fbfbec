#pragma once
// Common angles in rad.
#include <numbers>

namespace simuli {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kTurn = 2.0 * std::numbers::pi;
inline constexpr double kDegree = std::numbers::pi / 180.0;

}  // namespace simuli

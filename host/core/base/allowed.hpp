#pragma once
// Allowed values of a field of an options struct, for visit_fields() (fields.hpp).
#include <array>
#include <limits>
#include <string>

namespace simuli {

/// Numbers between two bounds; never infinities or NaN.
struct Allowed {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool above = false;  // excludes the lower bound
  double also = std::numeric_limits<double>::quiet_NaN();  // one more allowed value
  bool even = false;  // only even numbers

  [[nodiscard]] bool holds(double value) const;
  /// "0 or more", "above 0, at most 1", "0, or 8 to 7200 and even".
  [[nodiscard]] std::string text() const;
};

/// Includes both bounds.
[[nodiscard]] constexpr Allowed range(double least, double most) { return {.least = least, .most = most}; }
[[nodiscard]] constexpr Allowed at_least(double least) { return {.least = least}; }
[[nodiscard]] constexpr Allowed above(double least) { return {.least = least, .above = true}; }
[[nodiscard]] constexpr Allowed above(double least, double most) {
  return {.least = least, .most = most, .above = true};
}
[[nodiscard]] constexpr Allowed either(double also, Allowed other) {
  other.also = also;
  return other;
}
[[nodiscard]] constexpr Allowed zero_or(Allowed other) { return either(0.0, other); }
[[nodiscard]] constexpr Allowed even(Allowed other) {
  other.even = true;
  return other;
}

/// Values of a field that trainings accept.
enum class InTraining : char {
  kAny,          // any value that is allowed
  kNoGradients,  // only the default: other values have no backward pass
  kFixed,  // only the default: other values would have no effect, or are not offered
};

/// Names of an enum's values 0, 1, ...
template <class... Names>
[[nodiscard]] constexpr std::array<const char*, sizeof...(Names)> one_of(Names... names) {
  return {names...};
}

}  // namespace simuli

#pragma once
// What values a field of an options struct may have: for visit_fields() beside the struct (fields.hpp).
#include <array>
#include <limits>
#include <string>

namespace simuli {

/// Numbers between two bounds. Infinities and NaN are never among them.
struct Allowed {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool above = false;                                      // the least itself is not allowed
  double also = std::numeric_limits<double>::quiet_NaN();  // is, wherever the bounds are
  bool even = false;                                       // even numbers alone

  [[nodiscard]] bool holds(double value) const;
  /// "0 or more", "above 0, at most 1", "0, or 8 to 7200 and even".
  [[nodiscard]] std::string text() const;
};

/// Both bounds are allowed.
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

/// What trainings take of a field, where its values matter to them.
enum class InTraining : char {
  kAny,          // any value that is allowed
  kNoGradients,  // the default alone: other values have no backward pass
  kFixed,        // the default alone: other values would change nothing, or are not offered
};

/// The names of an enum's values 0, 1, ...
template <class... Names>
[[nodiscard]] constexpr std::array<const char*, sizeof...(Names)> one_of(Names... names) {
  return {names...};
}

}  // namespace simuli

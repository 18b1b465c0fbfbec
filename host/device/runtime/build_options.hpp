#pragma once
#include <concepts>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <type_traits>

#include "host/core/base/precision.hpp"

namespace simuli {

/// Options that specialise a kernel text: integers and enums by -D, and the precision of `real`. Floats are
/// kernel arguments, because each new value of a definition compiles a new program. -cl-fast-relaxed-math is
/// never used: it breaks rounding by magic numbers.
class BuildOptions {
 public:
  /// Adds -D NAME=VALUE and replaces an earlier value of the name. Throws Error{kInternal} when the name is not
  /// an identifier.
  template <class T>
  requires std::integral<T> || std::is_enum_v<T> BuildOptions& define(const std::string& name, T value) {
    return define_text(name, text_of(value));
  }
  /// kDouble defines SIMULI_REAL_DOUBLE=1; kFloat, the default, defines nothing.
  BuildOptions& real(Precision precision);

  /// Returns the options whose names `source` uses outside of `//` comments: options that a kernel does not use
  /// do not compile another program.
  [[nodiscard]] BuildOptions named_in(std::string_view source) const;

  [[nodiscard]] Precision precision() const { return precision_; }
  /// The compiler's options, sorted by name.
  [[nodiscard]] std::string text() const;

 private:
  template <class T>
  static std::string text_of(T value) {
    if constexpr (std::is_enum_v<T>) {
      return text_of(static_cast<std::underlying_type_t<T>>(value));
    } else if constexpr (std::is_same_v<T, bool>) {
      return value ? "1" : "0";
    } else {
      return std::to_string(value);
    }
  }
  BuildOptions& define_text(const std::string& name, std::string value);

  std::map<std::string, std::string> defines_;
  Precision precision_ = Precision::kFloat;
};

}  // namespace simuli

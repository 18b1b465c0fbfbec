#pragma once
#include <concepts>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <type_traits>

#include "host/core/base/precision.hpp"

namespace simuli {

/// How kernel text is specialised: integers and enums by -D, and the one axis `real`. Floats travel as
/// kernel arguments, as each new value would be a new program. -cl-fast-relaxed-math is never used:
/// it breaks magic-number rounding.
class BuildOptions {
 public:
  /// -D NAME=VALUE; a name defined again takes the new value. Error{kInternal} when the name is no
  /// identifier.
  template <class T>
  requires std::integral<T> || std::is_enum_v<T> BuildOptions& define(const std::string& name, T value) {
    return define_text(name, text_of(value));
  }
  /// kDouble defines SIMULI_REAL_DOUBLE=1; kFloat, the default, defines nothing.
  BuildOptions& real(Precision precision);

  /// Without the names that `source` doesn't hold as a word outside of its `//` comments: what kernels don't
  /// look at makes no other program of them.
  [[nodiscard]] BuildOptions named_in(std::string_view source) const;

  [[nodiscard]] Precision precision() const { return precision_; }
  /// The options as the compiler gets them: canonical, sorted by name.
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

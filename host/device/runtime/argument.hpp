#pragma once
// Types and names of kernel arguments as the host declares them.
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>

#include "host/device/runtime/declaration.hpp"

namespace simuli {

/// The OpenCL C name of type T in kernel declarations. Each struct of cl/shared is registered in the header
/// that first uses it: template <> struct ClTypeName<LidarParams> {
///   static constexpr std::string_view value = "LidarParams"; };
template <class T>
struct ClTypeName;
#define SIMULI_CL_TYPE(type, name)                  \
  template <>                                       \
  struct ClTypeName<type> {                         \
    static constexpr std::string_view value = name; \
  }
SIMULI_CL_TYPE(float, "float");
SIMULI_CL_TYPE(double, "double");
SIMULI_CL_TYPE(std::int8_t, "char");
SIMULI_CL_TYPE(std::uint8_t, "uchar");
SIMULI_CL_TYPE(std::int16_t, "short");
SIMULI_CL_TYPE(std::uint16_t, "ushort");
SIMULI_CL_TYPE(std::int32_t, "int");
SIMULI_CL_TYPE(std::uint32_t, "uint");
SIMULI_CL_TYPE(std::int64_t, "long");
SIMULI_CL_TYPE(std::uint64_t, "ulong");
#undef SIMULI_CL_TYPE

/// An argument's name: a literal, so that launches after the first compare addresses.
class ArgumentName {
 public:
  consteval ArgumentName(const char* text) : text_(text) {}  // NOLINT(google-explicit-constructor)
  [[nodiscard]] constexpr const char* text() const { return text_; }

 private:
  const char* text_;
};

/// __local T*: binds that many bytes.
struct Local {
  std::size_t bytes = 0;
};

namespace detail {

/// The type of an argument that the host passes. One object per type: launches after the first compare addresses.
struct PassedType {
  std::string_view element;  // "uint", "FrameParams"; "real" has the program's precision
  ArgumentSpace space = ArgumentSpace::kValue;
  bool is_const = false;
  std::size_t real_bytes = 0;  // bytes of one struct of reals
};
inline constexpr PassedType kPassedReal{"real", ArgumentSpace::kValue, false};
inline constexpr PassedType kPassedLocal{"", ArgumentSpace::kLocal, false};
template <class T>
inline constexpr PassedType kPassedValue{ClTypeName<T>::value, ArgumentSpace::kValue, false};
template <class T>
inline constexpr PassedType kPassedBuffer{
    ClTypeName<std::remove_const_t<T>>::value, ArgumentSpace::kGlobal, std::is_const_v<T>};
template <class Struct, class Real>
inline constexpr PassedType kPassedStructs{ClTypeName<std::remove_const_t<Struct>>::value,
                                           ArgumentSpace::kGlobal,
                                           std::is_const_v<Struct>,
                                           sizeof(Real)};

}  // namespace detail

}  // namespace simuli

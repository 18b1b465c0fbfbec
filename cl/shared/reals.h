// reals.h - structs shared by both languages that contain only `real`s: float or double by the build; on the
// host the type requested by the code (double, or jets where lenses are fitted).
#ifndef SIMULI_CL_SHARED_REALS_H
#define SIMULI_CL_SHARED_REALS_H

#ifdef __cplusplus
#include <array>
#include <bit>
#include <cstddef>
#define SIM_REALS(name) \
  template <class real> \
  struct name
#define SIM_REALS_END(name)
#define SIM_REALS_OF(name) name<real>

namespace simuli::shared {
/// Number of reals in a struct, and the reals in memory order, as they are uploaded.
template <template <class> class Struct>
inline constexpr std::size_t kReals = sizeof(Struct<double>) / sizeof(double);
template <template <class> class Struct>
[[nodiscard]] std::array<double, kReals<Struct>> reals_of(const Struct<double>& constants) {
  return std::bit_cast<std::array<double, kReals<Struct>>>(constants);
}
template <template <class> class Struct>
[[nodiscard]] Struct<double> from_reals(const std::array<double, kReals<Struct>>& reals) {
  return std::bit_cast<Struct<double>>(reals);
}
}  // namespace simuli::shared
#else
#define SIM_REALS(name) typedef struct
#define SIM_REALS_END(name) name
#define SIM_REALS_OF(name) name
#endif
#endif

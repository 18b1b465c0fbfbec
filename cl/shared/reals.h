// reals.h - structs that both languages share and that hold `real`s alone: float or double as the build, on the host
// what its text asks for (double; jets where lenses are fitted).
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
/// How many reals a struct has, and these in the order in which they lie in memory: as they are uploaded.
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

#pragma once
// Adam on a few numbers that the host holds.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace simuli {

/// N numbers with their optimiser. Without pointers, so that checkpoints store it as it is.
template <std::size_t N>
struct SmallAdam {
  std::array<double, N> value{};
  std::array<double, N> first{}, second{};
  std::uint64_t steps = 0;

  /// A step of Adam, rate[i] of value[i]. A gradient that is not finite moves nothing.
  void step(const std::array<double, N>& gradient, const std::array<double, N>& rate) {
    constexpr double kBeta1 = 0.9, kBeta2 = 0.999, kEpsilon = 1e-15;
    if (!std::all_of(gradient.begin(), gradient.end(), [](double g) { return std::isfinite(g); })) return;
    ++steps;
    const auto t = static_cast<double>(steps);
    for (std::size_t i = 0; i < N; ++i) {
      const double g = gradient[i];
      first[i] = kBeta1 * first[i] + (1.0 - kBeta1) * g;
      second[i] = kBeta2 * second[i] + (1.0 - kBeta2) * g * g;
      const double m = first[i] / (1.0 - std::pow(kBeta1, t));
      const double v = second[i] / (1.0 - std::pow(kBeta2, t));
      value[i] -= rate[i] * m / (std::sqrt(v) + kEpsilon);
    }
  }
};

}  // namespace simuli

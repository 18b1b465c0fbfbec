#pragma once
// Adam for a few numbers on the host.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace simuli {

/// N numbers and their moments. Without pointers, so that checkpoints store it directly.
template <std::size_t N>
struct SmallAdam {
  std::array<double, N> value{};
  std::array<double, N> first{}, second{};
  std::uint64_t steps = 0;

  /// Takes a step with rate[i] for value[i]. Non-finite gradients change nothing.
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

#include "host/device/render/frame/paper/normal_samples.hpp"

#include <cmath>
#include <numbers>

#include "cl/shared/layout.h"
#include "host/core/base/splitmix.hpp"

namespace simuli {

std::vector<double> normal_samples() {
  std::vector<double> values;
  std::uint64_t state = 0;
  const auto uniform = [&state] {
    const std::uint64_t z = splitmix(state);
    state += kSplitmixStep;
    return (static_cast<double>(z >> 11U) + 0.5) * 0x1p-53;
  };
  for (int pair = 0; pair < SIM_MONTE_CARLO / 2; ++pair) {
    double sample[3];
    for (double& value : sample) {
      const double radius = std::sqrt(-2.0 * std::log(uniform()));
      value = radius * std::cos(2.0 * std::numbers::pi * uniform());
    }
    for (const double sign : {1.0, -1.0}) {
      for (const double value : sample) values.push_back(sign * value);
    }
  }
  return values;
}

}  // namespace simuli

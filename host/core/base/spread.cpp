#include "host/core/base/spread.hpp"

#include <algorithm>
#include <cstddef>

namespace simuli {

Spread spread_of(std::vector<double> samples) {
  std::sort(samples.begin(), samples.end());
  const auto at = [&](double share) {
    const double place = share * static_cast<double>(samples.size() - 1);
    const auto low = static_cast<std::size_t>(place);
    const std::size_t high = std::min(low + 1, samples.size() - 1);
    const double part = place - static_cast<double>(low);
    return (1.0 - part) * samples[low] + part * samples[high];
  };
  return {at(0.5), (at(0.75) - at(0.25)) / 2.0};
}

}  // namespace simuli

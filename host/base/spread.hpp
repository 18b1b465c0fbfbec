#pragma once
#include <vector>

namespace simuli {

/// Median and half the distance of the quartiles of at least one sample.
struct Spread {
  double median = 0.0;
  double half_iqr = 0.0;
};
[[nodiscard]] Spread spread_of(std::vector<double> samples);

}  // namespace simuli

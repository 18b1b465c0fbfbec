#pragma once
#include <vector>

namespace simuli {

/// Median and half the distance of the quartiles of at least one sample.
struct Spread {
  double median = 0.0;
  double half_iqr = 0.0;
};
[[nodiscard]] Spread spread_of(std::vector<double> samples);

/// The middle one, the upper of the two when their number is even; 0 of nothing.
[[nodiscard]] double upper_median(std::vector<double> samples);

}  // namespace simuli

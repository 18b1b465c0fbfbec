#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

namespace simuli {

/// Median and half the interquartile range of at least one sample.
struct Spread {
  double median = 0.0;
  double half_iqr = 0.0;
};
[[nodiscard]] Spread spread_of(std::vector<double> samples);

/// Returns the median, the upper of two middle values; 0 without values.
template <class Number>
[[nodiscard]] Number upper_median(std::vector<Number> samples) {
  if (samples.empty()) return Number{0};
  const auto middle = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2);
  std::nth_element(samples.begin(), middle, samples.end());
  return *middle;
}

}  // namespace simuli

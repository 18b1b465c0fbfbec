#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

namespace simuli::calibration {

/// The middle value, the upper of the two when their number is even; 0 of nothing.
[[nodiscard]] inline double upper_median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace simuli::calibration

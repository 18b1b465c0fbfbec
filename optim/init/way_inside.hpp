#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace simuli {

/// Where a ray is inside a box around the origin, shares of `direction`; first >= last: nowhere.
inline std::pair<double, double> way_inside(const Eigen::Vector3d& origin,
                                            const Eigen::Vector3d& direction,
                                            const Eigen::Vector3d& half) {
  double first = 0.0, last = std::numeric_limits<double>::infinity();
  for (Eigen::Index k = 0; k < 3; ++k) {
    if (direction[k] == 0.0) {
      if (std::abs(origin[k]) > half[k]) return {1.0, 0.0};
      continue;
    }
    const double a = (-half[k] - origin[k]) / direction[k], b = (half[k] - origin[k]) / direction[k];
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  return {first, last};
}

}  // namespace simuli

#pragma once
// Far shells of a drive's stretches. What no laser reaches stands on one distance, which is right for those
// who drive along the stretch that taught it and for nobody else: each stretch has a shell of its own, and a
// frame sees that of the stretch where it is taken.
#include <Eigen/Core>
#include <vector>

namespace simuli {

/// The far shell of one stretch.
struct Vista {
  std::vector<Eigen::Vector3d>
      path_m;  // where it was seen from, in the order that was driven: world, one place at least
};

/// How much of each vista is seen from `eye` (world, m), 0 to 1: all of the nearest one, and of the others
/// the less the farther their paths are behind the nearest, none from 10 m on. Continuous in the eye's place.
[[nodiscard]] std::vector<double> vista_shares(const std::vector<Vista>& vistas, const Eigen::Vector3d& eye);

}  // namespace simuli

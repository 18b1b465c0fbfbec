#pragma once
// What cameras see from each stretch of a long drive. A stretch is trained from its own pictures, and what it
// has come to is right for those who drive along it: what no laser reaches stands on one distance, and what
// is far ahead is as it looks from there, not as the next stretch knows it from near. So each stretch has a
// camera set of its own, and a frame sees that of the stretch where it is taken.
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "host/core/scene/actor.hpp"

namespace simuli {

/// What is seen from one stretch.
struct Vista {
  std::vector<Eigen::Vector3d>
      path_m;  // where it was seen from, in the order that was driven: world, one place at least
  std::vector<Actor> occluders = {};  // as Scene::occluders; what stands behind them is of this vista
};

/// How much of each vista is seen from `eye` (world, m), 0 to 1: all of the nearest one, and of the others
/// the less the farther their paths are behind the nearest, none from 4 m on (from farther beside all paths
/// than that: from as far). Continuous in the eye's place.
[[nodiscard]] std::vector<double> vista_shares(const std::vector<Vista>& vistas, const Eigen::Vector3d& eye);

/// Which vista's path is nearest to a point (world, m), the first of those alike; 0 without vistas.
[[nodiscard]] std::size_t nearest_vista(const std::vector<Vista>& vistas, const Eigen::Vector3d& p_world);

}  // namespace simuli

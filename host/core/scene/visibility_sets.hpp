#pragma once
// What cameras see from each chunk of a long drive. A chunk is trained from its own pictures, and what it
// has come to is right for those who drive along it: what no laser reaches stands on one distance, and what
// is far ahead is as it looks from there, not as the next chunk knows it from near. So each chunk has a
// camera set of its own, and a frame sees that of the chunk where it is taken.
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "host/core/scene/actor.hpp"

namespace simuli {

/// What is seen from one chunk.
struct VisibilitySet {
  std::vector<Eigen::Vector3d>
      path_m;  // where it was seen from, in the order that was driven: world, one place at least
  std::vector<Actor> occluders = {};  // as Scene::occluders; what stands behind them is of this visibility_set
};

/// How much of each visibility_set is seen from `eye` (world, m), 0 to 1: all of the nearest one, and of the others
/// the less the farther their paths are behind the nearest, none from 4 m on (from farther beside all paths
/// than that: from as far). Continuous in the eye's place.
[[nodiscard]] std::vector<double> visibility_shares(const std::vector<VisibilitySet>& visibility_sets, const Eigen::Vector3d& eye);

/// Which visibility_set's path is nearest to a point (world, m), the first of those alike; 0 without visibility_sets.
[[nodiscard]] std::size_t nearest_visibility_set(const std::vector<VisibilitySet>& visibility_sets, const Eigen::Vector3d& p_world);

}  // namespace simuli

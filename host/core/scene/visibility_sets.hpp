#pragma once
// Visibility sets: one camera set per chunk of a long drive. A chunk is trained on its own pictures and is
// valid for views along it: distant objects without LiDAR returns have approximate distances, and objects ahead
// look as from this chunk. A frame renders the set of the chunk where it is taken.
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "host/core/scene/actor.hpp"

namespace simuli {

/// The camera set of one chunk.
struct VisibilitySet {
  std::vector<Eigen::Vector3d>
      path_m;  // path of the chunk in driving order: world, at least one position
  std::vector<Actor> occluders = {};  // as Scene::occluders, of this visibility set
};

/// Returns the share of each visibility set seen from `eye` (world, m), 0 to 1: 1 for the nearest, decreasing
/// with the additional distance of the others' paths to 0 at 4 m (or at the nearest path's distance, if
/// larger). Continuous in the position of the eye.
[[nodiscard]] std::vector<double> visibility_shares(const std::vector<VisibilitySet>& visibility_sets, const Eigen::Vector3d& eye);

/// Returns the visibility set whose path is nearest to a point (world, m), the first of equal ones; 0 without
/// any.
[[nodiscard]] std::size_t nearest_visibility_set(const std::vector<VisibilitySet>& visibility_sets, const Eigen::Vector3d& p_world);

}  // namespace simuli

#pragma once
// Ground that cameras see and lasers don't reach: below their lowest beams as the drive begins, and between the
// rings that they leave on it.
#include <vector>

#include "host/core/base/pose.hpp"
#include "host/core/scene/ground/ground_map.hpp"
#include "optim/init/points/points.hpp"

namespace simuli {

/// A point for each square of 2 voxel_m within 8 m of the rig that holds none of `points` near the ground: as
/// high as `ground` where that is known, else on the plane on which the rig stands. `scene_from_rig`: along the
/// path; `points`: of the background, scene frame. None where the ground is nowhere known below the rig.
[[nodiscard]] PointSet ground_near(const GroundMap& ground,
                                   const std::vector<Pose>& scene_from_rig,
                                   const PointSet& points,
                                   double voxel_m);

}  // namespace simuli

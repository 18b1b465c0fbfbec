#pragma once
// Ground that cameras see and LiDARs do not reach: below their lowest beams at the start of the drive, and
// between the rings of returns.
#include <vector>

#include "host/core/base/pose.hpp"
#include "host/core/scene/ground/ground_map.hpp"
#include "optim/init/points/points.hpp"

namespace simuli {

/// Returns a point for each square of side 2 voxel_m within 8 m of the rig that contains none of `points` near
/// the ground, at the height of `ground` where known, else on the plane under the rig. `scene_from_rig`: along
/// the path; `points`: background, scene frame. Empty where no ground is known under the rig.
[[nodiscard]] PointSet ground_near(const GroundMap& ground,
                                   const std::vector<Pose>& scene_from_rig,
                                   const PointSet& points,
                                   double voxel_m);

}  // namespace simuli

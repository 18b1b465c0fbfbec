#pragma once
#include <string>
#include <vector>

#include "host/core/base/pose.hpp"
#include "host/core/scene/ground/ground_map.hpp"

namespace simuli {

/// Returns an ASAM OpenDRIVE 1.4 file with one road along the driven trajectory (not a survey). Coordinates are
/// metres in the frame of `rig` (at least one pose, in time order, z up) and `ground`; without a geoReference,
/// because the position on Earth is unknown. Lanes are kLaneWidth_m wide: the right one is centred on the
/// trajectory, the left one beside it is for oncoming traffic. Its height is the ground's below the trajectory;
/// where the ground is unknown, the rig's height minus its usual height above the ground; without any ground,
/// the rig's own height.
[[nodiscard]] std::string road_map(const std::vector<Pose>& rig, const GroundMap& ground);

inline constexpr double kLaneWidth_m = 3.5;

}  // namespace simuli

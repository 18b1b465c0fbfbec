#pragma once
#include <string>
#include <vector>

#include "host/core/base/pose.hpp"
#include "host/core/scene/ground/ground_map.hpp"

namespace simuli {

/// A file of ASAM OpenDRIVE 1.4: one road, made from where the rig drove and not from a survey. Places are m
/// as those of `rig` (one pose at least, in order of time, z up) and of `ground`; without a geoReference, as
/// nothing tells where on Earth they are. A lane is as wide as kLaneWidth_m; the right one lies about the
/// path, the left one, for those who come, beside it. Its height is the ground's below the path; where that
/// is not known it keeps the rig's usual height above it, and where it is known nowhere it is the rig's own.
[[nodiscard]] std::string road_map(const std::vector<Pose>& rig, const GroundMap& ground);

inline constexpr double kLaneWidth_m = 3.5;

}  // namespace simuli

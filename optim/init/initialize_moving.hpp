#pragma once
// Detection of moving objects: points that other sweeps see through.
#include <cstdint>
#include <vector>

#include "host/core/base/pose.hpp"
#include "host/core/sensors/lidar.hpp"
#include "io/log/log.hpp"
#include "optim/init/points/points.hpp"

namespace simuli {

class PointBlocks;

/// Votes of the sweeps on one point.
struct PointVotes {
  std::uint16_t through = 0;  // sweeps whose rays around the point all passed beyond it
  std::uint16_t there = 0;  // sweeps that hit something at its distance
};

/// Adds one sweep's vote on every point within 40 m of the sensor, or 70 m with closely spaced rows. Poses map
/// the sensor's frame to the scene at the start and end of the sweep. A sweep abstains where fewer than half of
/// the rays around a point returned, and where the point is nearer than these returns by too little. votes:
/// [points]; `blocks`: of the points, limits the test to near ones without changing votes.
void vote_on_points(const Sweep& sweep,
                    const Lidar& lidar,
                    const Pose& scene_from_lidar_start,
                    const Pose& scene_from_lidar_end,
                    const PointSet& points,
                    std::vector<PointVotes>& votes,
                    const PointBlocks* blocks = nullptr);

/// Returns true for a point that at least three sweeps see through, and more than hit it: it was on an object
/// that left or came later.
[[nodiscard]] bool is_moving(const PointVotes& votes);

}  // namespace simuli

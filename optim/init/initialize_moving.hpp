#pragma once
// What moved through the log: points at which other sweeps look through thin air.
#include <cstdint>
#include <vector>

#include "host/core/base/pose.hpp"
#include "host/core/sensors/lidar.hpp"
#include "io/log/log.hpp"
#include "optim/init/points/points.hpp"

namespace simuli {

class PointBlocks;

/// What the sweeps say about one point.
struct PointVotes {
  std::uint16_t through = 0;  // sweeps whose rays around the point all went on beyond it
  std::uint16_t there = 0;    // sweeps that met something at its distance
};

/// Lets one sweep vote on every point within 40 m of the sensor, or 70 m where its rows are near each other. Poses
/// take the sensor's frame to the scene's at the start and the end of the sweep. A sweep abstains where fewer than half
/// of the rays around a point returned, and where the point is nearer than what those rays met, but not clearly. votes:
/// [points]; `blocks`: of the points, so that only those near the sensor are looked at; the votes are the same.
void vote_on_points(const Sweep& sweep,
                    const Lidar& lidar,
                    const Pose& scene_from_lidar_start,
                    const Pose& scene_from_lidar_end,
                    const PointSet& points,
                    std::vector<PointVotes>& votes,
                    const PointBlocks* blocks = nullptr);

/// True for a point that at least three sweeps look through, and more than there are sweeps that met it: it
/// was on something that drove away, or came later.
[[nodiscard]] bool is_moving(const PointVotes& votes);

}  // namespace simuli

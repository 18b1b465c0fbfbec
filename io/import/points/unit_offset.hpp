#pragma once
// Units of one LiDAR differ: mostly by one angle that all of their beams share.
#include <Eigen/Core>
#include <string>
#include <vector>

#include "host/core/sensors/lidar.hpp"

namespace simuli {

/// How much higher (rad, to 1 degree) all beams point than the table's, by where points (m, in its frame) lie. 0 where
/// the table as it is explains them about as well.
[[nodiscard]] double unit_offset(const Lidar& table, const std::vector<Eigen::Vector3d>& points);

/// Turns all beams up by that. The line that tells it.
std::string raise_beams(Lidar& table, double offset);

}  // namespace simuli

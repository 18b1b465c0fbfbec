#pragma once
// Differences between units of one LiDAR model, mostly a common elevation offset.
#include <Eigen/Core>
#include <string>
#include <vector>

#include "host/core/base/pose.hpp"
#include "host/core/sensors/lidar.hpp"

namespace simuli {

/// Returns the elevation offset (rad, up to 1 degree) of all beams from the table's, estimated from points (m,
/// in its frame); 0 if the table explains them about as well.
[[nodiscard]] double unit_offset(const Lidar& table, const std::vector<Eigen::Vector3d>& points);

/// Mounting of a unit, estimated from its points.
struct UnitMounting {
  Pose table_from_sensor;  // rotation about x and y, and translation
  // Mean distance of points from their beams' cones, without and with it.
  double before_rad = 0.0, left_rad = 0.0;
};

/// Estimates the deviation from a published mounting from points (m, in that frame); identity if it explains
/// them about as well. An offset of half the beam spacing assigns points to other beams, and a tilted cone does
/// so on one side.
[[nodiscard]] UnitMounting unit_mounting(const Lidar& table, const std::vector<Eigen::Vector3d>& points);

/// Raises all beams by the offset. Returns a line that reports it.
std::string raise_beams(Lidar& table, double offset);

}  // namespace simuli

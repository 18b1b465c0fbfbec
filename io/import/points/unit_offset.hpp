#pragma once
// Units of one LiDAR differ: mostly by one angle that all of their beams share.
#include <Eigen/Core>
#include <string>
#include <vector>

#include "host/core/base/pose.hpp"
#include "host/core/sensors/lidar.hpp"

namespace simuli {

/// How much higher (rad, to 1 degree) all beams point than the table's, by where points (m, in its frame) lie. 0 where
/// the table as it is explains them about as well.
[[nodiscard]] double unit_offset(const Lidar& table, const std::vector<Eigen::Vector3d>& points);

/// How a unit stands, by its points.
struct UnitMounting {
  Pose table_from_sensor;  // turned about x and y, and moved
  // Mean distance of points from their rows' cones, without and with it.
  double before_rad = 0.0, left_rad = 0.0;
};

/// Of a LiDAR whose frame others measured: by where points (m, in that frame) lie. The identity where that explains
/// them about as well. An error of half a row's gap gives points to other rows, and a turned cone does so on one side.
[[nodiscard]] UnitMounting unit_mounting(const Lidar& table, const std::vector<Eigen::Vector3d>& points);

/// Turns all beams up by that. The line that tells it.
std::string raise_beams(Lidar& table, double offset);

}  // namespace simuli

#pragma once
// Inverse of the ray functions: row and column of a LiDAR at rest whose ray passes a point.
#include <Eigen/Core>
#include <optional>

#include "host/core/sensors/lidar.hpp"

namespace simuli {

/// Position of a point in the firings of one row.
struct LidarHit {
  int row = 0;
  double column = 0.0;  // fractional; integer at a firing, [-1/2, columns - 1/2] inside the sweep
  double azimuth = 0.0;          // rad, of the row's ray through the point, seen from above
  double elevation_error = 0.0;  // rad, elevation of the point above the row's beam, from the beam's origin
  double range = 0.0;            // m, from the beam's origin
  double time_fraction = 0.0;    // of the sweep, at the fractional column
};

/// Returns the position of `p_sensor` in `row`, in closed form with all of the row's offsets. Empty when no ray
/// of the row reaches the point's azimuth: outside a partial field of view, or nearer to the spin axis than the
/// beam passes.
[[nodiscard]] std::optional<LidarHit> locate_in_row(const Lidar& lidar,
                                                    int row,
                                                    const Eigen::Vector3d& p_sensor);

/// Returns the firing whose ray passes `p_sensor` at the smallest angle over all rows. With lever arms two rows
/// may pass exactly; either is returned.
[[nodiscard]] std::optional<LidarHit> locate(const Lidar& lidar, const Eigen::Vector3d& p_sensor);

}  // namespace simuli

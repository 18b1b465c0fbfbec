#pragma once
// Bare points back on the firing grid of the LiDAR that measured them.
#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "io/log/log.hpp"

namespace simuli {

struct MeasuredPoint {
  Eigen::Vector3d position;  // m, in the sensor's frame when it was measured
  float intensity = 0.0F;    // [0, 1]
  int row = -1;              // of the Lidar; below 0: the one of the nearest elevation
  double time_fraction = std::numeric_limits<double>::quiet_NaN();  // of the sweep; NaN: its column's
};

struct PointReport {
  std::size_t points = 0;
  std::size_t unplaced = 0;        // too near, beside all beams or columns, or more than columns; left out
  std::size_t echoes = 0;          // farther ones of a ray that has another; left out
  std::size_t rays = 0;            // of all firing grids
  std::size_t returned = 0;        // of these
  std::vector<std::string> notes;  // where a LiDAR is another than its table says
};

/// Column at which `lidar` looks to `azimuth` (rad, any turn) with a row, counted from the middle of column
/// 0: -0.5 to columns - 0.5 within its turn.
[[nodiscard]] double column_of(const Lidar& lidar, int row, double azimuth);

/// How far a point may be off each row's beam, rad: half the distance of the beams beside it, 0.01 at least.
[[nodiscard]] std::vector<double> row_tolerances(const Lidar& lidar);

/// The row of the nearest elevation; -1 when none is within its tolerance.
[[nodiscard]] int nearest_row(const Lidar& lidar,
                              const std::vector<double>& tolerances,
                              const Eigen::Vector3d& p_sensor);

/// The full firing grid: measured rays as measured, in the columns nearest to theirs in the least squares
/// sense, all others nominal with what their row's neighbours are off. Adds to the report. A point farther
/// than half the distance of the beams beside it from its own, 0.01 rad at least, is on none.
[[nodiscard]] Sweep grid_points(const std::vector<MeasuredPoint>& points,
                                const Lidar& lidar,
                                PointReport& report);

/// Error{kInput} naming `file` for more than 5 % of all points unplaced: another sensor than the table says.
void need_placed(const PointReport& report, const std::string& file);

}  // namespace simuli

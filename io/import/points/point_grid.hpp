#pragma once
// Assignment of points to the firing grid of their LiDAR.
#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "io/log/log.hpp"

namespace simuli {

struct MeasuredPoint {
  Eigen::Vector3d position;  // m, in the sensor's frame at the time of measurement
  float intensity = 0.0F;    // [0, 1]
  int row = -1;              // beam of the Lidar; negative: the nearest in elevation
  // share of the sweep; NaN: its column's time
  double time_fraction = std::numeric_limits<double>::quiet_NaN();
};

struct PointReport {
  std::size_t points = 0;
  std::size_t unplaced = 0;        // too close, off all beams or columns, or more than columns; left out
  std::size_t echoes = 0;          // farther points of a ray with another point; left out
  std::size_t rays = 0;            // of all firing grids
  std::size_t returned = 0;        // of these
  std::vector<std::string> notes;  // differences between a LiDAR and its table
};

/// Returns the column at which `lidar` measures `azimuth` (rad, any revolution) with a beam, relative to the
/// centre of column 0: -0.5 to columns - 0.5.
[[nodiscard]] double column_of(const Lidar& lidar, int row, double azimuth);

/// Returns the largest distance of a point from each beam, rad: half the distance of its neighbours, at least
/// 0.01.
[[nodiscard]] std::vector<double> row_tolerances(const Lidar& lidar);

/// Returns the beam nearest in elevation; -1 if none is within its tolerance.
[[nodiscard]] int nearest_row(const Lidar& lidar,
                              const std::vector<double>& tolerances,
                              const Eigen::Vector3d& p_sensor);

/// Returns the full firing grid: measured rays in the columns of the least-squares fit, all other rays nominal
/// plus the interpolated deviation of their beam's neighbours. Adds to the report. A point farther from its
/// beam than half the distance of the neighbouring beams, at least 0.01 rad, is left out.
[[nodiscard]] Sweep grid_points(const std::vector<MeasuredPoint>& points,
                                const Lidar& lidar,
                                PointReport& report);

/// Throws Error{kInput} naming `file` if more than 5 % of all points were left out, which indicates a wrong
/// table.
void need_placed(const PointReport& report, const std::string& file);

}  // namespace simuli

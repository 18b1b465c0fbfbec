#pragma once
// Estimates the beam table of a spinning LiDAR from sweeps of bare points: no rings, no order, no calibration.
//
// A beam sweeps a cone (exactly: a hyperboloid) about the spin axis: all of its points lie on one line in the
// plane of axis distance and height. Lines are found by voting, then fitted. An encoder quantises azimuths: for
// a beam that passes beside the axis the grid is only sharp with the right horizontal offset; and because all
// beams fire together, the encoder ticks of a beam determine its azimuth offset.
#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "host/core/sensors/lidar.hpp"

namespace simuli::calibration {

using RawSweep = std::vector<Eigen::Vector3d>;  // m, sensor frame, as measured

struct BeamEstimate {
  LidarRow row;
  std::size_t points = 0;
  double elevation_sigma = 0.0;        // rad
  double vertical_offset_sigma = 0.0;  // m; above kWorstOffset_m the offset is taken from other rows
  double residual = 0.0;               // rad, 1.4826 * median absolute deviation of its points
  bool vertical_offset_known = false;
  bool horizontal_offset_known = false;
  bool azimuth_offset_known = false;
};

struct BeamTable {
  std::vector<BeamEstimate> rows;  // top to bottom
  double columns = 0.0;  // firings per revolution, mean; 0: too few points
  int encoder_ticks = 0;  // per revolution; 0: azimuths are on no grid
  std::size_t points = 0;
  std::size_t near = 0;  // points nearer than kNearestTelling_m, not assigned to beams
  std::size_t unplaced = 0;  // other points not assigned to a beam
  double returned_share = 0.0;  // of all firings
  double range_min = 0.0;  // m, nearest point with a direction
  double range_max = 0.0;       // m, farthest point
  std::vector<std::string> notes;  // undetermined parameters, with reasons
};

inline constexpr double kWorstOffset_m = 5e-3;
/// Below this range lever arms and spot shapes make a point's beam ambiguous.
inline constexpr double kNearestTelling_m = 0.5;

/// Throws Error{kNumeric} when the points are not on beams.
[[nodiscard]] BeamTable find_beams(const std::vector<RawSweep>& sweeps);

/// Returns a model with full revolutions that start at azimuth pi: columns rounded, azimuth offsets relative to
/// their mean.
[[nodiscard]] Lidar lidar_of(const BeamTable& table, const std::string& name, SpinDirection spin);

}  // namespace simuli::calibration

#pragma once
// The beam table of a spinning LiDAR from sweeps that list bare points: no rings, no order, no calibration.
//
// A beam sweeps a cone (exactly: a hyperboloid) about the spin axis: all of its points lie on one line in the
// plane of distance from the axis and height. The lines are found by voting, then fitted. An encoder
// quantises the azimuths: seen along a beam that passes beside the axis the grid blurs, unless the offset is
// allowed for; and since all beams fire together, which encoder ticks a beam fired at gives its azimuth
// offset.
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
  double vertical_offset_sigma = 0.0;  // m; above kWorstOffset_m the offset is the other rows' and only that
  double residual = 0.0;               // rad, 1.4826 * median absolute deviation of its points
  bool vertical_offset_known = false;
  bool horizontal_offset_known = false;
  bool azimuth_offset_known = false;
};

struct BeamTable {
  std::vector<BeamEstimate> rows;  // top to bottom
  double columns = 0.0;            // firings per turn, mean; 0: too few points to tell
  int encoder_ticks = 0;           // per turn; 0: azimuths lie on no grid
  std::size_t points = 0;
  std::size_t near = 0;         // of these nearer than kNearestTelling_m: on no beam, and held against none
  std::size_t unplaced = 0;     // of the others on no beam
  double returned_share = 0.0;  // of all firings
  double range_min = 0.0;       // m, nearest point that has a direction
  double range_max = 0.0;       // m, farthest point
  std::vector<std::string> notes;  // what the sweeps do not determine, and why
};

inline constexpr double kWorstOffset_m = 5e-3;
/// The lever arms of beams and the shape of their spots hide a nearer point's beam.
inline constexpr double kNearestTelling_m = 0.5;

/// Throws Error{kNumeric} when the points lie on no beams.
[[nodiscard]] BeamTable find_beams(const std::vector<RawSweep>& sweeps);

/// A model of full turns that start where the azimuth is pi: columns rounded, azimuth offsets about their
/// mean.
[[nodiscard]] Lidar lidar_of(const BeamTable& table, const std::string& name, SpinDirection spin);

}  // namespace simuli::calibration

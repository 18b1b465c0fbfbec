#pragma once
// Number of firings per revolution from the azimuths of points.
#include <vector>

#include "host/core/sensors/lidar.hpp"

namespace simuli {

/// Azimuths (rad, any revolution) of a beam's points in a sweep, in any order.
using FiredRun = std::vector<double>;

/// Returns the number of steps within `span` (rad) for which most neighbours are one step apart; 0 if this
/// holds for few beams (thinned clouds, few points). The fastest of several rates is used.
[[nodiscard]] double columns_by_steps(const std::vector<FiredRun>& runs, double span);

/// Returns how well the runs agree with grids of that step (rad), each with its own offset, from 0 to 1; 0
/// without runs.
[[nodiscard]] double fit_of_step(const std::vector<FiredRun>& runs, double step);

/// Detects beams that fire in every second (third, fourth) column only, from the points of some sweeps: sets
/// the pattern and moves the first column onto their grid, by less than one column. `runs` cycle through the
/// beams from 0. Beams without points are unchanged, and all beams if no grid is found. Returns the number of
/// changed beams.
int set_firing_pattern(const std::vector<FiredRun>& runs, Lidar& lidar);

}  // namespace simuli

#pragma once
// How many firings a turn has, by the azimuths of the points that they measured.
#include <vector>

#include "host/core/sensors/lidar.hpp"

namespace simuli {

/// Azimuths (rad, any turn) of what a row measured in a sweep, in any order.
using FiredRun = std::vector<double>;

/// Steps within `span` (rad), of which most neighbours are one apart; 0 where those of few rows are: clouds that are
/// thinned, or of few points. Of rows that fire at different rates those of the fastest count.
[[nodiscard]] double columns_by_steps(const std::vector<FiredRun>& runs, double span);

/// 0 to 1: how near the runs lie to grids of that step (rad), each to its own; 0 without runs.
[[nodiscard]] double fit_of_step(const std::vector<FiredRun>& runs, double step);

/// Which rows fire in every second column only (or third, fourth), where the points of some sweeps tell it: sets it,
/// and moves the first column onto the grid that they lie on, by less than one. `runs` are of the rows in turns, from
/// row 0 on. Rows without points stay as they are, all of them where no grid is seen. Returns how many were changed.
int set_firing_pattern(const std::vector<FiredRun>& runs, Lidar& lidar);

}  // namespace simuli

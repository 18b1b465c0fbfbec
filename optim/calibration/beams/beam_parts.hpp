#pragma once
// Inside beams.cpp and beam_azimuths.cpp.
#include <vector>

#include "optim/calibration/beams/beams.hpp"

namespace simuli::calibration {

/// A point as its beam sees it.
struct BeamPoint {
  double azimuth = 0.0;   // rad, of the point about the spin axis
  double distance = 0.0;  // m, from the spin axis
  double height = 0.0;    // m
};

/// [rows][sweeps][points]
using BeamPoints = std::vector<std::vector<std::vector<BeamPoint>>>;

/// Fills in horizontal and azimuth offsets, the encoder's ticks and the columns.
void find_azimuths(const BeamPoints& points, BeamTable& table);

}  // namespace simuli::calibration

#pragma once
// Shared by beams.cpp and beam_azimuths.cpp.
#include <vector>

#include "optim/calibration/beams/beams.hpp"

namespace simuli::calibration {

/// A point in cylindrical coordinates of the sensor.
struct BeamPoint {
  double azimuth = 0.0;   // rad, of the point about the spin axis
  double distance = 0.0;  // m, from the spin axis
  double height = 0.0;    // m
};

/// [rows][sweeps][points]
using BeamPoints = std::vector<std::vector<std::vector<BeamPoint>>>;

/// Estimates horizontal and azimuth offsets, encoder ticks and columns.
void find_azimuths(const BeamPoints& points, BeamTable& table);

}  // namespace simuli::calibration

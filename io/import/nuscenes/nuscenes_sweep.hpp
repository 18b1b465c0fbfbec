#pragma once
// Sweeps of nuScenes' HDL-32E, for io/import/nuscenes/nuscenes.cpp and tests.
#include <filesystem>
#include <string>
#include <vector>

#include "io/log/log.hpp"

namespace simuli::nuscenes {

/// Returns the sensor of these files in the data set's frame (x right, y forward): the built-in beam table with
/// the number of firings that all files have; one or two further firings of some files are not imported.
[[nodiscard]] Lidar lidar_of(const std::vector<std::filesystem::path>& files, const std::string& name);

/// Reads a file's firing grid: float32 x y z intensity ring, 32 beams per firing, the lowest first. Points are
/// stored in the frame at the sweep's end; `start_from_end`, the sensor's motion during the sweep, is
/// compensated. Throws Error{kInput} for invalid sizes and rings, NaN, Inf.
[[nodiscard]] Sweep read_turn(const std::filesystem::path& file,
                              const Lidar& lidar,
                              const Pose& start_from_end);

}  // namespace simuli::nuscenes
